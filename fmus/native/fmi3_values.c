/* FMI 3.0: getting and setting values. Array variables pass as many values as they have elements.

   Float64, Int32 (integers), Int64 (enumerations) and Boolean exist; all other types have no
   variables. */
#include "access.h"
#include "fmi3.h"

enum { SETTABLE3 = INSTANTIATED | INITIALIZATION | RUNNING };

#define VALUES3(name, ctype, type)                                                                 \
    static bool get_3##name(Instance *self, const fmi3ValueReference vr[], size_t n,               \
                            ctype out[], size_t n_out)                                             \
    {                                                                                              \
        GET_VALUES(self, vr, n, type, out, n_out, ctype)                                           \
    }                                                                                              \
    static bool set_3##name(Instance *self, const fmi3ValueReference vr[], size_t n,               \
                            const ctype in[], size_t n_in)                                         \
    {                                                                                              \
        SET_VALUES(self, vr, n, type, in, n_in)                                                    \
    }                                                                                              \
    fmi3Status fmi3Get##name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,       \
                             ctype values[], size_t n_values)                                      \
    {                                                                                              \
        ALLOW3(READABLE);                                                                          \
        return status3(get_3##name(self, vr, n, values, n_values));                                \
    }                                                                                              \
    fmi3Status fmi3Set##name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,       \
                             const ctype values[], size_t n_values)                                \
    {                                                                                              \
        ALLOW3(SETTABLE3);                                                                         \
        return status3(set_3##name(self, vr, n, values, n_values));                                \
    }

VALUES3(Float64, fmi3Float64, REAL)
VALUES3(Int32, fmi3Int32, INTEGER)
VALUES3(Int64, fmi3Int64, ENUMERATION)
VALUES3(Boolean, fmi3Boolean, BOOLEAN)

static fmi3Status none_of(Instance *self, size_t n, const char *type)
{
    if (n == 0)
        return fmi3OK;
    report(self, STATUS_ERROR, "there are no variables of type %s", type);
    return fmi3Error;
}

#define ABSENT(name, ctype)                                                                        \
    fmi3Status fmi3Get##name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,       \
                             ctype values[], size_t n_values)                                      \
    {                                                                                              \
        (void)vr, (void)values, (void)n_values;                                                    \
        ALLOW3(READABLE);                                                                          \
        return none_of(self, n, #name);                                                            \
    }                                                                                              \
    fmi3Status fmi3Set##name(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,       \
                             const ctype values[], size_t n_values)                                \
    {                                                                                              \
        (void)vr, (void)values, (void)n_values;                                                    \
        ALLOW3(SETTABLE3);                                                                         \
        return none_of(self, n, #name);                                                            \
    }

ABSENT(Float32, fmi3Float32)
ABSENT(Int8, fmi3Int8)
ABSENT(UInt8, fmi3UInt8)
ABSENT(Int16, fmi3Int16)
ABSENT(UInt16, fmi3UInt16)
ABSENT(UInt32, fmi3UInt32)
ABSENT(UInt64, fmi3UInt64)
ABSENT(String, fmi3String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                         size_t sizes[], fmi3Binary values[], size_t n_values)
{
    (void)vr, (void)sizes, (void)values, (void)n_values;
    ALLOW3(READABLE);
    return none_of(self, n, "Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                         const size_t sizes[], const fmi3Binary values[], size_t n_values)
{
    (void)vr, (void)sizes, (void)values, (void)n_values;
    ALLOW3(SETTABLE3);
    return none_of(self, n, "Binary");
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                        fmi3Clock values[])
{
    (void)vr, (void)values;
    ALLOW3(READABLE);
    return none_of(self, n, "Clock");
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                        const fmi3Clock values[])
{
    (void)vr, (void)values;
    ALLOW3(SETTABLE3);
    return none_of(self, n, "Clock");
}
