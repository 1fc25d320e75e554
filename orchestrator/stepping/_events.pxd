"""A step of an FMI 3.0 FMU: going on after an early return, handling events. As in :mod:`..fmi.fmi3`."""

from libc.math cimport fabs

from orchestrator.stepping._fmi cimport ENDED, STUCK, WARNING, Change, Part, Step3, Update, bint8

cdef enum:
    ROUNDS = 100  # of event iteration


cdef inline int step_three(Part *part, double time, double width) noexcept nogil:
    cdef double end = time + width, last = 0.0
    cdef double near = 1e-12 * max(fabs(end), width)
    cdef bint8 event = 0, stop = 0, early = 0
    cdef int i, status
    for i in range(ROUNDS):
        status = (<Step3>part.step)(part.component, time, end - time, part.final, &event, &stop,
                                    &early, &last)
        if status > WARNING:
            return status
        if stop:
            return ENDED
        if event:
            status = events(part)
            if status > WARNING:
                return status
        if not early or last >= end - near:
            return status
        time = last
    return STUCK


cdef inline int events(Part *part) noexcept nogil:
    cdef bint8 again = 0, stop = 0, nominals = 0, states = 0, defined = 0
    cdef double time = 0.0
    cdef int i, status = (<Change>part.enter_events)(part.component)
    if status > WARNING:
        return status
    for i in range(ROUNDS):
        status = (<Update>part.update)(part.component, &again, &stop, &nominals, &states,
                                       &defined, &time)
        if status > WARNING:
            return status
        if stop:
            return ENDED
        if not again:
            return (<Change>part.enter_steps)(part.component)
    return STUCK
