"""The C functions of FMI 2.0 and 3.0 that steps need, and one FMU as the loop sees it."""

ctypedef unsigned char bint8
ctypedef int (*Transfer2)(void *, const unsigned *, size_t, void *) noexcept nogil
ctypedef int (*Transfer3)(void *, const unsigned *, size_t, void *, size_t) noexcept nogil
ctypedef int (*Derive)(void *, const unsigned *, size_t, const int *, const double *) noexcept nogil
ctypedef int (*Step2)(void *, double, double, int) noexcept nogil
ctypedef int (*Step3)(void *, double, double, bint8, bint8 *, bint8 *, bint8 *, double *) noexcept nogil
ctypedef int (*Change)(void *) noexcept nogil
ctypedef int (*Update)(void *, bint8 *, bint8 *, bint8 *, bint8 *, bint8 *, double *) noexcept nogil

cdef enum:
    WARNING = 1  # as in log
    ENDED = 100
    STUCK = 101

cdef struct Move:
    void *call
    const unsigned *references
    double *values
    unsigned known  # number of references
    unsigned count  # number of values
    int type
    bint three  # of FMI 3.0

cdef struct Course:
    void *derive
    size_t inputs, derived, directions
    const int *direction  # first and count of each
    const Py_ssize_t *which
    const unsigned *references
    const int *orders
    const double *weights
    double *polynomial
    double *derivatives
    double *older
    double *oldest

# What every step uses stands first: of a thousand FMUs little else passes through caches.
cdef struct Part:
    void *component
    void *step
    double *inputs
    const int *sources
    Move *set
    Move *get
    unsigned driven, sets, gets
    bint8 three
    bint8 plain  # FMI 2.0, one step at every communication point, inputs held
    bint8 final  # no state of before will be restored
    bint8 converts
    const double *gain
    const double *shift
    Course *course
    long long every, parts
    void *enter_events
    void *update
    void *enter_steps
