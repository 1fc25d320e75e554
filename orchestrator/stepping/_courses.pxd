"""The course of inputs inside a step, as in :mod:`.moves`."""

from libc.math cimport fabs, sqrt

from orchestrator.stepping._fmi cimport Course

cdef extern from *:
    """
    #define UNIT 1e-9 /* as in moves */
    """
    const double UNIT


cdef inline void follow(Course *course, double *values, double width) noexcept nogil:
    """Turn the copied inputs into base, slope and curvature of a step; remember them."""
    cdef size_t n = course.inputs, k, row
    cdef double newest
    cdef const double *w
    for k in range(n):
        newest = values[course.which[k]]
        for row in range(3):
            w = course.weights + 3 * row * n + k
            course.polynomial[row * n + k] = (
                w[0] * newest + w[n] * course.older[k] + w[2 * n] * course.oldest[k]
            )
        course.oldest[k] = course.older[k]
        course.older[k] = newest
    for k in range(course.directions):
        end_on_sphere(course, course.direction[2 * k], course.direction[2 * k + 1], width)
    for k in range(n):
        values[course.which[k]] = course.polynomial[k]
        course.derivatives[k] = course.polynomial[n + k]
        course.derivatives[n + k] = course.polynomial[2 * n + k]


cdef inline void follow_on(Course *course, double *values, double time) noexcept nogil:
    """The course from a time after the step's start on."""
    cdef size_t n = course.inputs, k
    cdef const double *base = course.polynomial
    cdef const double *slope = course.polynomial + n
    cdef const double *curvature = course.polynomial + 2 * n
    for k in range(n):
        values[course.which[k]] = base[k] + time * (slope[k] + 0.5 * time * curvature[k])
        course.derivatives[k] = slope[k] + time * curvature[k]


cdef inline void end_on_sphere(Course *course, size_t first, size_t count,
                               double width) noexcept nogil:
    """Let inputs that form a unit vector form one at the end of the step too."""
    cdef const double *newest = course.older + first
    cdef const double *base = course.polynomial + first
    cdef double *slope = course.polynomial + course.inputs + first
    cdef const double *curvature = course.polynomial + 2 * course.inputs + first
    cdef double end[4]
    cdef double before = 0.0, square = 0.0
    cdef size_t k
    for k in range(count):
        end[k] = base[k] + width * (slope[k] + 0.5 * width * curvature[k])
        square += end[k] * end[k]
        before += newest[k] * newest[k]
    if fabs(before - 1.0) <= UNIT and square > 0.0:
        for k in range(count):
            slope[k] += (1.0 / sqrt(square) - 1.0) / width * end[k]
