# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The communication steps over the FMUs' own C functions, without the GIL.

It does what :mod:`.stepper` does, in the same order on the same array of values, so that both give
the same bits. See there for the meaning; here are only pointers. What is rare is left to Python:
the loop halts there, and goes on where it halted.
"""

from libc.stdint cimport uintptr_t
from libc.stdlib cimport calloc, free

from orchestrator.stepping._conversion cimport (
    BOOL, DOUBLE, FLOAT, INT8, INT16, INT32, INT64, UINT8, UINT16, UINT32, UINT64, from_doubles,
    to_doubles,
)
from orchestrator.stepping._courses cimport follow, follow_on
from orchestrator.stepping._events cimport step_three
from orchestrator.stepping._fmi cimport WARNING, Course, Derive, Move, Part, Step2, Transfer2, Transfer3
from orchestrator.stepping._traps cimport BEGIN_TRAPS, END_TRAPS, TRAPPED, WHICH_TRAP

cdef extern from *:
    """
    #if defined __GNUC__
    #define AHEAD(address) __builtin_prefetch((address), 1)
    #else
    #define AHEAD(address) ((void)(address))
    #endif
    """
    void AHEAD(const void *) noexcept nogil

cdef enum:
    WRITE, STEP, READ, UPDATE, SOLVE  # as plan.Act
cdef enum:
    MANY = 64  # FMUs, of which not all stay in the nearest cache
    LINE = 64  # bytes that a cache fetches at once
    LINES = 8  # of an FMU's memory that are fetched while the one before steps

TYPES = {"f8": DOUBLE, "f4": FLOAT, "i1": INT8, "u1": UINT8, "i2": INT16, "u2": UINT16,
         "i4": INT32, "u4": UINT32, "i8": INT64, "u8": UINT64, "b1": BOOL}


cdef class Loop:
    """The compiled plan. Every array given must keep its memory as long as the loop is used."""

    cdef Part *parts
    cdef Move *moves
    cdef Course *courses
    cdef int *links  # the sources of all inputs
    cdef void *scratch
    cdef double *values
    cdef const Py_ssize_t *recorded
    cdef const int *acts
    cdef size_t length, columns, filled, used, linked
    cdef double start, step
    cdef list kept
    cdef bint free, many
    cdef double free_time, free_width
    cdef readonly size_t rows  # recorded since the last fresh start
    # where and why the loop halted
    cdef readonly size_t act
    cdef readonly size_t number
    cdef readonly int status
    cdef readonly long long part

    def __cinit__(self, size_t count, size_t moves, size_t links, size_t widest):
        self.parts = <Part *>calloc(count + 1, sizeof(Part))
        self.moves = <Move *>calloc(moves + 1, sizeof(Move))
        self.courses = <Course *>calloc(count + 1, sizeof(Course))
        self.links = <int *>calloc(links + 1, sizeof(int))
        self.scratch = calloc(widest + 1, sizeof(double))
        if (self.parts is NULL or self.moves is NULL or self.courses is NULL
                or self.links is NULL or self.scratch is NULL):
            raise MemoryError
        self.many = count > MANY
        self.kept = []

    def __dealloc__(self):
        free(self.parts)
        free(self.moves)
        free(self.courses)
        free(self.links)
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
        cdef size_t k
        cdef uintptr_t step = functions[0], enter = functions[1]
        cdef uintptr_t update = functions[2], leave = functions[3]
        self.kept += [gain, shift]
        part.component, part.step = <void *>component, <void *>step
        part.enter_events, part.update = <void *>enter, <void *>update
        part.enter_steps = <void *>leave
        part.three, part.final, part.every, part.parts = three, final, every, parts
        part.inputs = self.values + first
        part.driven = sources.shape[0]
        part.sources = self.links + self.linked
        for k in range(part.driven):
            self.links[self.linked + k] = sources[k]
        self.linked += part.driven
        if gain is not None:
            part.converts = True
            factors = gain
            part.gain = &factors[0]
            factors = shift
            part.shift = &factors[0]
        part.set, part.sets = self.moves + self.used, len(sets)
        self._add_moves(sets, three)
        part.get, part.gets = self.moves + self.used, len(gets)
        self._add_moves(gets, three)
        part.plain = not three and every == 1 and parts == 1 and all(
            len(moves) != 1 or moves[0][4] == DOUBLE for moves in (sets, gets)
        )
        self.filled += 1

    def follow(self, uintptr_t derive, const Py_ssize_t[::1] which,
               const unsigned int[::1] references, const int[::1] orders,
               const int[::1] directions, const double[:, :, ::1] weights, double[:, ::1] polynomial,
               double[::1] derivatives, Py_ssize_t history):
        """Let inputs of the FMU added last follow a course."""
        cdef Part *part = &self.parts[self.filled - 1]
        cdef Course *course = &self.courses[self.filled - 1]
        part.plain = False
        part.course = course
        self.kept += [which, references, orders, directions, weights, polynomial, derivatives]
        course.derive = <void *>derive
        course.inputs, course.derived = which.shape[0], references.shape[0]
        course.which, course.references, course.orders = &which[0], &references[0], &orders[0]
        course.directions = directions.shape[0] // 2
        course.direction = &directions[0] if course.directions else NULL
        course.weights, course.polynomial = &weights[0, 0, 0], &polynomial[0, 0]
        course.derivatives = &derivatives[0]
        course.older = self.values + history
        course.oldest = course.older + course.inputs

    cdef _add_moves(self, list transfers, bint three):
        cdef const unsigned int[::1] references
        cdef Move *move
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
            BEGIN_TRAPS()
            done = self._unless_trapped(first, last, stride, rows, act)
            END_TRAPS()
        return done

    cdef bint _unless_trapped(self, size_t first, size_t last, size_t stride, double *rows,
                              size_t act) noexcept nogil:
        if TRAPPED():
            self.status = WHICH_TRAP()
            return False
        return self._advance(first, last, stride, rows, act)

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
            self.act, self.part = act, 0
            what = self.acts[2 * act]
            if what == SOLVE:
                self.status = 0
                return False
            part = &self.parts[self.acts[2 * act + 1]]
            if self.many and what == WRITE:
                self._fetch(part + 1)
            if part.plain and not self.free:
                if not self._plainly(part, what, number):
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
                    return False
            act += 1
        return True

    cdef inline void _fetch(self, Part *part) noexcept nogil:
        """Let the memory of the FMU that comes next be on its way. No address can do harm."""
        cdef const char *memory = <const char *>part.component
        cdef int k
        for k in range(LINES):
            AHEAD(memory + k * LINE)

    cdef inline bint _plainly(self, Part *part, int what, size_t number) noexcept nogil:
        """What most FMUs need: for each act one call."""
        cdef Move *move
        cdef int status
        if what == STEP:
            status = (<Step2>part.step)(
                part.component, self.start + <double>number * self.step, self.step, part.final
            )
            self.status = status
            return status <= WARNING
        if what == READ:
            if part.gets != 1:
                return self._read(part)
            move = part.get
        else:
            self._copy(part)
            if part.sets != 1:
                return self._update_values(part)
            move = part.set
        status = (<Transfer2>move.call)(part.component, move.references, move.known, move.values)
        self.status = status
        return status <= WARNING

    cdef inline void _copy(self, Part *part) noexcept nogil:
        cdef size_t k
        for k in range(part.driven):
            part.inputs[k] = self.values[part.sources[k]]
        if part.converts:
            for k in range(part.driven):
                part.inputs[k] = part.inputs[k] * part.gain[k]
                part.inputs[k] = part.inputs[k] + part.shift[k]

    cdef inline bint _write(self, Part *part) noexcept nogil:
        self._copy(part)
        if part.course is not NULL:
            follow(part.course, self.values,
                   self.free_width if self.free else <double>part.every * self.step)
        return self._put(part)

    cdef inline bint _put(self, Part *part) noexcept nogil:
        cdef Course *course = part.course
        if not self._update_values(part):
            return False
        if course is not NULL:
            self.status = (<Derive>course.derive)(part.component, course.references,
                                                  course.derived, course.orders,
                                                  course.derivatives)
            return self.status <= WARNING
        return True

    cdef inline bint _update(self, Part *part) noexcept nogil:
        self._copy(part)
        return self._update_values(part)

    cdef inline bint _update_values(self, Part *part) noexcept nogil:
        cdef size_t k
        for k in range(part.sets):
            if not self._set(part, part.set + k):
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
            self.part = i
            if i and part.course is not NULL:
                follow_on(part.course, self.values, <double>i * piece)
                if not self._put(part):
                    return False
            if part.three:
                self.status = step_three(part, time + <double>i * piece, piece)
            else:
                self.status = (<Step2>part.step)(
                    part.component, time + <double>i * piece, piece, part.final
                )
            if self.status > WARNING:
                return False
        return True

    cdef inline bint _read(self, Part *part) noexcept nogil:
        cdef size_t k
        for k in range(part.gets):
            if not self._get(part, part.get + k):
                return False
        return True

    cdef inline bint _set(self, Part *part, Move *move) noexcept nogil:
        if move.type == DOUBLE:
            self.status = self._call(part, move, move.values)
        else:
            from_doubles(move.values, move.count, move.type, self.scratch)
            self.status = self._call(part, move, self.scratch)
        return self.status <= WARNING

    cdef inline bint _get(self, Part *part, Move *move) noexcept nogil:
        if move.type == DOUBLE:
            self.status = self._call(part, move, move.values)
        else:
            self.status = self._call(part, move, self.scratch)
            to_doubles(move.values, move.count, move.type, self.scratch)
        return self.status <= WARNING

    cdef inline int _call(self, Part *part, Move *move, void *data) noexcept nogil:
        if move.three:
            return (<Transfer3>move.call)(part.component, move.references, move.known, data,
                                          move.count)
        return (<Transfer2>move.call)(part.component, move.references, move.known, data)
