# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The communication steps over the FMUs' own C functions, without the GIL.

It does what :mod:`.stepper` does, in the same order on the same array of values, so that both give
the same bits. See there for the meaning; here are only pointers. What is rare is left to Python:
the loop halts there, and goes on where it halted.
"""

from libc.math cimport fabs
from libc.stdint cimport (
    int8_t, int16_t, int32_t, int64_t, uint8_t, uint16_t, uint32_t, uint64_t, uintptr_t,
)
from libc.stdlib cimport calloc, free

ctypedef unsigned char bint8
ctypedef int (*Transfer2)(void *, const unsigned int *, size_t, void *) noexcept nogil
ctypedef int (*Transfer3)(void *, const unsigned int *, size_t, void *, size_t) noexcept nogil
ctypedef int (*Derive)(void *, const unsigned int *, size_t, const int *, const double *) noexcept nogil
ctypedef int (*Step2)(void *, double, double, int) noexcept nogil
ctypedef int (*Step3)(void *, double, double, bint8, bint8 *, bint8 *, bint8 *, double *) noexcept nogil
ctypedef int (*Change)(void *) noexcept nogil
ctypedef int (*Update)(void *, bint8 *, bint8 *, bint8 *, bint8 *, bint8 *, double *) noexcept nogil

cdef enum:
    WRITE, STEP, READ, UPDATE, SOLVE  # as plan.Act
cdef enum:
    DOUBLE, FLOAT, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, BOOL

TYPES = {"f8": DOUBLE, "f4": FLOAT, "i1": INT8, "u1": UINT8, "i2": INT16, "u2": UINT16,
         "i4": INT32, "u4": UINT32, "i8": INT64, "u8": UINT64, "b1": BOOL}
cdef enum:
    WARNING = 1  # as in log
    ENDED = 100
    STUCK = 101
cdef enum:
    ROUNDS = 100  # of event iteration

cdef struct Move:
    void *call
    const unsigned int *references
    size_t known  # number of references
    size_t count  # number of values
    double *values
    int type
    bint three  # of FMI 3.0

cdef struct Part:
    void *component
    void *step
    void *enter_events
    void *update
    void *enter_steps
    bint three
    bint plain  # FMI 2.0, one step at every communication point, inputs held
    int final  # no state of before will be restored
    long long every, parts
    double *inputs
    size_t driven
    const Py_ssize_t *sources
    const double *gain
    const double *shift
    size_t sets, first_set
    size_t gets, first_get
    # the course of inputs
    void *derive
    size_t followed, derived
    const Py_ssize_t *which
    const unsigned int *references
    const int *orders
    const double *weights
    double *polynomial
    double *derivatives
    double *older
    double *oldest


cdef class Loop:
    """The compiled plan. Every array given must keep its memory as long as the loop is used."""

    cdef Part *parts
    cdef Move *moves
    cdef void *scratch
    cdef double *values
    cdef const Py_ssize_t *recorded
    cdef const int *acts
    cdef size_t length, columns, filled, used
    cdef double start, step
    cdef list kept
    cdef bint free
    cdef double free_time, free_width
    cdef readonly size_t rows  # recorded since the last fresh start
    # where and why the loop halted
    cdef readonly size_t act
    cdef readonly size_t number
    cdef readonly int status
    cdef readonly long long part

    def __cinit__(self, size_t count, size_t moves, size_t widest):
        self.parts = <Part *>calloc(count + 1, sizeof(Part))
        self.moves = <Move *>calloc(moves + 1, sizeof(Move))
        self.scratch = calloc(widest + 1, sizeof(double))
        if self.parts is NULL or self.moves is NULL or self.scratch is NULL:
            raise MemoryError
        self.kept = []

    def __dealloc__(self):
        free(self.parts)
        free(self.moves)
        free(self.scratch)

    def prepare(self, double[::1] values, const Py_ssize_t[::1] recorded, const int[::1] acts,
                double start, double step):
        """Say which array the values live in, what is recorded, what is done, how time goes.

        ``acts``: pairs of an act and the position of its FMU.
        """
        self.kept += [values, recorded, acts]
        self.values = &values[0] if values.shape[0] else NULL
        self.recorded = &recorded[0] if recorded.shape[0] else NULL
        self.columns = recorded.shape[0]
        self.acts = &acts[0] if acts.shape[0] else NULL
        self.length = acts.shape[0] // 2
        self.start, self.step = start, step

    def add(self, uintptr_t component, tuple functions, bint three, bint final,
            long long every, long long parts, Py_ssize_t first, const Py_ssize_t[::1] sources, gain, shift,
            list sets, list gets):
        """Add an FMU. ``sets``, ``gets``: (function, references, first, count, type).

        ``sources``: what is copied to the inputs from ``first`` on, before they are set.
        ``functions``: step and, in FMI 3.0 with event mode, entering it, update, leaving it.
        """
        cdef Part *part = &self.parts[self.filled]
        cdef const double[::1] factors
        cdef uintptr_t step = functions[0], enter = functions[1]
        cdef uintptr_t update = functions[2], leave = functions[3]
        self.kept += [sources, gain, shift]
        part.component, part.step = <void *>component, <void *>step
        part.enter_events, part.update = <void *>enter, <void *>update
        part.enter_steps = <void *>leave
        part.three, part.final, part.every, part.parts = three, final, every, parts
        part.inputs = self.values + first
        part.driven = sources.shape[0]
        part.sources = &sources[0] if part.driven else NULL
        if gain is not None:
            factors = gain
            part.gain = &factors[0]
            factors = shift
            part.shift = &factors[0]
        part.first_set, part.sets = self._moves(sets, three)
        part.first_get, part.gets = self._moves(gets, three)
        part.plain = not three and every == 1 and parts == 1 and all(
            len(moves) != 1 or moves[0][4] == DOUBLE for moves in (sets, gets)
        )
        self.filled += 1

    def follow(self, uintptr_t derive, const Py_ssize_t[::1] which,
               const unsigned int[::1] references, const int[::1] orders,
               const double[:, :, ::1] weights, double[:, ::1] polynomial,
               double[::1] derivatives, Py_ssize_t history):
        """Let inputs of the FMU added last follow a course."""
        cdef Part *part = &self.parts[self.filled - 1]
        part.plain = False
        self.kept += [which, references, orders, weights, polynomial, derivatives]
        part.derive = <void *>derive
        part.followed, part.derived = which.shape[0], references.shape[0]
        part.which, part.references, part.orders = &which[0], &references[0], &orders[0]
        part.weights, part.polynomial = &weights[0, 0, 0], &polynomial[0, 0]
        part.derivatives = &derivatives[0]
        part.older = self.values + history
        part.oldest = part.older + part.followed

    cdef tuple _moves(self, list transfers, bint three):
        cdef const unsigned int[::1] references
        cdef Move *move
        cdef size_t first = self.used
        for function, known, position, count, type_ in transfers:
            references = known
            self.kept.append(references)
            move = &self.moves[self.used]
            move.call = <void *><uintptr_t>function
            move.references = &references[0]
            move.known, move.count = references.shape[0], count
            move.values = self.values + <Py_ssize_t>position
            move.type, move.three = type_, three
            self.used += 1
        return first, len(transfers)

    def advance(self, size_t first, size_t last, size_t stride, double[:, ::1] buffer,
                size_t act=0, object free=None):
        """Take steps; False if it halted, as told by ``act``, ``number``, ``status``, ``part``.

        ``act``: where in the first step to begin; rows go on after those recorded before, unless
        it is 0. ``free``: time and width of a step off the grid.
        """
        cdef bint done
        cdef double *rows = &buffer[0, 0] if buffer.shape[0] and self.columns else NULL
        self.free = free is not None
        if self.free:
            self.free_time, self.free_width = free
        if act == 0:
            self.rows = 0
        with nogil:
            done = self._advance(first, last, stride, rows, act)
        return done

    cdef bint _advance(self, size_t first, size_t last, size_t stride, double *rows,
                       size_t act) noexcept nogil:
        cdef size_t number, column
        if rows is not NULL:
            rows += self.rows * self.columns
        for number in range(first, last):
            self.number = number
            if not self._communicate(number, act):
                return False
            act = 0
            if (number + 1) % stride == 0:
                for column in range(self.columns):
                    rows[column] = self.values[self.recorded[column]]
                rows += self.columns
                self.rows += 1
        return True

    cdef inline bint _communicate(self, size_t number, size_t act) noexcept nogil:
        cdef Part *part
        cdef int what
        cdef bint good
        while act < self.length:
            what = self.acts[2 * act]
            if what == SOLVE:
                self.act, self.status = act, 0
                return False
            part = &self.parts[self.acts[2 * act + 1]]
            if part.plain and not self.free:
                if not self._plainly(part, what, number):
                    self.act = act
                    return False
            elif part.every == 1 or self.free or (number + 1) % part.every == 0:
                if what == WRITE:
                    good = self._write(part)
                elif what == STEP:
                    good = self._step(part, number)
                elif what == READ:
                    good = self._read(part)
                else:
                    good = self._update(part)
                if not good:
                    self.act = act
                    return False
            act += 1
        return True

    cdef inline bint _plainly(self, Part *part, int what, size_t number) noexcept nogil:
        """What most FMUs need: for each act one call."""
        cdef Move *move
        cdef int status
        if what == STEP:
            status = (<Step2>part.step)(
                part.component, self.start + <double>number * self.step, self.step, part.final
            )
            if status > WARNING:
                self.part, self.status = 0, status
            return status <= WARNING
        if what == READ:
            if part.gets != 1:
                return self._read(part)
            move = &self.moves[part.first_get]
        else:
            self._copy(part)
            if part.sets != 1:
                return self._update_values(part)
            move = &self.moves[part.first_set]
        status = (<Transfer2>move.call)(part.component, move.references, move.known, move.values)
        self.status = status
        return status <= WARNING

    cdef inline void _copy(self, Part *part) noexcept nogil:
        cdef size_t k
        for k in range(part.driven):
            part.inputs[k] = self.values[part.sources[k]]
        if part.gain is not NULL:
            for k in range(part.driven):
                part.inputs[k] = part.inputs[k] * part.gain[k]
                part.inputs[k] = part.inputs[k] + part.shift[k]

    cdef inline bint _write(self, Part *part) noexcept nogil:
        self._copy(part)
        if part.followed:
            self._follow(part)
        return self._put(part)

    cdef inline bint _put(self, Part *part) noexcept nogil:
        if not self._update_values(part):
            return False
        if part.followed:
            self.status = (<Derive>part.derive)(part.component, part.references, part.derived,
                                                part.orders, part.derivatives)
            return self.status <= WARNING
        return True

    cdef inline bint _update(self, Part *part) noexcept nogil:
        self._copy(part)
        return self._update_values(part)

    cdef inline bint _update_values(self, Part *part) noexcept nogil:
        cdef size_t k
        for k in range(part.first_set, part.first_set + part.sets):
            if not self._set(part, &self.moves[k]):
                return False
        return True

    cdef inline bint _step(self, Part *part, size_t number) noexcept nogil:
        cdef double time, width, piece
        cdef long long i
        if self.free:
            time, width = self.free_time, self.free_width
        else:
            time = self.start + <double>(<long long>number + 1 - part.every) * self.step
            width = <double>part.every * self.step
        piece = width / <double>part.parts
        for i in range(part.parts):
            if i and part.followed:
                self._follow_on(part, <double>i * piece)
                if not self._put(part):
                    self.part = i
                    return False
            if part.three:
                self.status = self._step_three(part, time + <double>i * piece, piece)
            else:
                self.status = (<Step2>part.step)(
                    part.component, time + <double>i * piece, piece, part.final
                )
            if self.status > WARNING:
                self.part = i
                return False
        return True

    cdef int _step_three(self, Part *part, double time, double width) noexcept nogil:
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
                status = self._events(part)
                if status > WARNING:
                    return status
            if not early or last >= end - near:
                return status
            time = last
        return STUCK

    cdef int _events(self, Part *part) noexcept nogil:
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

    cdef inline bint _read(self, Part *part) noexcept nogil:
        cdef size_t k
        for k in range(part.first_get, part.first_get + part.gets):
            if not self._get(part, &self.moves[k]):
                return False
        return True

    cdef void _follow(self, Part *part) noexcept nogil:
        cdef size_t n = part.followed, k, row
        cdef double newest
        cdef const double *w
        for k in range(n):
            newest = self.values[part.which[k]]
            for row in range(3):
                w = part.weights + 3 * row * n + k
                part.polynomial[row * n + k] = (
                    w[0] * newest + w[n] * part.older[k] + w[2 * n] * part.oldest[k]
                )
            part.oldest[k] = part.older[k]
            part.older[k] = newest
            self.values[part.which[k]] = part.polynomial[k]
            part.derivatives[k] = part.polynomial[n + k]
            part.derivatives[n + k] = part.polynomial[2 * n + k]

    cdef void _follow_on(self, Part *part, double time) noexcept nogil:
        cdef size_t n = part.followed, k
        cdef const double *base = part.polynomial
        cdef const double *slope = part.polynomial + n
        cdef const double *curvature = part.polynomial + 2 * n
        for k in range(n):
            self.values[part.which[k]] = base[k] + time * (slope[k] + 0.5 * time * curvature[k])
            part.derivatives[k] = slope[k] + time * curvature[k]

    cdef inline bint _set(self, Part *part, Move *move) noexcept nogil:
        if move.type == DOUBLE:
            self.status = self._call(part, move, move.values)
        else:
            self._from_doubles(move)
            self.status = self._call(part, move, self.scratch)
        return self.status <= WARNING

    cdef inline bint _get(self, Part *part, Move *move) noexcept nogil:
        if move.type == DOUBLE:
            self.status = self._call(part, move, move.values)
        else:
            self.status = self._call(part, move, self.scratch)
            self._to_doubles(move)
        return self.status <= WARNING

    cdef inline int _call(self, Part *part, Move *move, void *data) noexcept nogil:
        if move.three:
            return (<Transfer3>move.call)(part.component, move.references, move.known, data,
                                          move.count)
        return (<Transfer2>move.call)(part.component, move.references, move.known, data)

    cdef void _from_doubles(self, Move *move) noexcept nogil:
        cdef size_t k
        cdef double *v = move.values
        for k in range(move.count):
            if move.type == INT32:
                (<int32_t *>self.scratch)[k] = <int32_t>v[k]
            elif move.type == BOOL:
                (<uint8_t *>self.scratch)[k] = v[k] != 0.0
            elif move.type == INT64:
                (<int64_t *>self.scratch)[k] = <int64_t>v[k]
            elif move.type == UINT64:
                (<uint64_t *>self.scratch)[k] = <uint64_t>v[k]
            elif move.type == UINT32:
                (<uint32_t *>self.scratch)[k] = <uint32_t>v[k]
            elif move.type == FLOAT:
                (<float *>self.scratch)[k] = <float>v[k]
            elif move.type == INT8:
                (<int8_t *>self.scratch)[k] = <int8_t>v[k]
            elif move.type == UINT8:
                (<uint8_t *>self.scratch)[k] = <uint8_t>v[k]
            elif move.type == INT16:
                (<int16_t *>self.scratch)[k] = <int16_t>v[k]
            else:
                (<uint16_t *>self.scratch)[k] = <uint16_t>v[k]

    cdef void _to_doubles(self, Move *move) noexcept nogil:
        cdef size_t k
        cdef double *v = move.values
        for k in range(move.count):
            if move.type == INT32:
                v[k] = (<int32_t *>self.scratch)[k]
            elif move.type == BOOL:
                v[k] = (<uint8_t *>self.scratch)[k] != 0
            elif move.type == INT64:
                v[k] = <double>(<int64_t *>self.scratch)[k]
            elif move.type == UINT64:
                v[k] = <double>(<uint64_t *>self.scratch)[k]
            elif move.type == UINT32:
                v[k] = (<uint32_t *>self.scratch)[k]
            elif move.type == FLOAT:
                v[k] = (<float *>self.scratch)[k]
            elif move.type == INT8:
                v[k] = (<int8_t *>self.scratch)[k]
            elif move.type == UINT8:
                v[k] = (<uint8_t *>self.scratch)[k]
            elif move.type == INT16:
                v[k] = (<int16_t *>self.scratch)[k]
            else:
                v[k] = (<uint16_t *>self.scratch)[k]
