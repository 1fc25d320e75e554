"""Values of all types of FMI from and to doubles, between the array of values and a buffer."""

from libc.stdint cimport (
    int8_t, int16_t, int32_t, int64_t, uint8_t, uint16_t, uint32_t, uint64_t,
)

cdef enum:
    DOUBLE, FLOAT, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, BOOL


cdef inline void from_doubles(const double *v, size_t count, int type, void *buffer) noexcept nogil:
    cdef size_t k
    for k in range(count):
        if type == INT32:
            (<int32_t *>buffer)[k] = <int32_t>v[k]
        elif type == BOOL:
            (<uint8_t *>buffer)[k] = v[k] != 0.0
        elif type == INT64:
            (<int64_t *>buffer)[k] = <int64_t>v[k]
        elif type == UINT64:
            (<uint64_t *>buffer)[k] = <uint64_t>v[k]
        elif type == UINT32:
            (<uint32_t *>buffer)[k] = <uint32_t>v[k]
        elif type == FLOAT:
            (<float *>buffer)[k] = <float>v[k]
        elif type == INT8:
            (<int8_t *>buffer)[k] = <int8_t>v[k]
        elif type == UINT8:
            (<uint8_t *>buffer)[k] = <uint8_t>v[k]
        elif type == INT16:
            (<int16_t *>buffer)[k] = <int16_t>v[k]
        else:
            (<uint16_t *>buffer)[k] = <uint16_t>v[k]


cdef inline void to_doubles(double *v, size_t count, int type, const void *buffer) noexcept nogil:
    cdef size_t k
    for k in range(count):
        if type == INT32:
            v[k] = (<const int32_t *>buffer)[k]
        elif type == BOOL:
            v[k] = (<const uint8_t *>buffer)[k] != 0
        elif type == INT64:
            v[k] = <double>(<const int64_t *>buffer)[k]
        elif type == UINT64:
            v[k] = <double>(<const uint64_t *>buffer)[k]
        elif type == UINT32:
            v[k] = (<const uint32_t *>buffer)[k]
        elif type == FLOAT:
            v[k] = (<const float *>buffer)[k]
        elif type == INT8:
            v[k] = (<const int8_t *>buffer)[k]
        elif type == UINT8:
            v[k] = (<const uint8_t *>buffer)[k]
        elif type == INT16:
            v[k] = (<const int16_t *>buffer)[k]
        else:
            v[k] = (<const uint16_t *>buffer)[k]
