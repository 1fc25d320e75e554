/* FMI 3.0: functions for features that these FMUs do not have. All are exported and refused:
   configuration mode, clocks, scheduled execution, dependencies that change at run time. */
#include "fmi3.h"

static fmi3Status absent(Instance *self, const char *what)
{
    report(self, STATUS_ERROR, "%s", what);
    return fmi3Error;
}

#define NO_CLOCKS "there are no clocks"

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    ALLOW3(INSTANTIATED | EVENT | STEP);
    return absent(self, "there are no structural parameters");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    ALLOW3(ANY_MODE);
    return absent(self, "there are no structural parameters");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference vr,
                                               size_t *count)
{
    (void)vr, (void)count;
    ALLOW3(ANY_MODE);
    return absent(self, "dependencies of elements are not offered");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elements[], fmi3ValueReference independents[],
                                       size_t independent_elements[], fmi3DependencyKind kinds[],
                                       size_t count)
{
    (void)dependent, (void)elements, (void)independents, (void)independent_elements;
    (void)kinds, (void)count;
    ALLOW3(ANY_MODE);
    return absent(self, "dependencies of elements are not offered");
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                  fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)vr, (void)n, (void)intervals, (void)qualifiers;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                   fmi3IntervalQualifier qualifiers[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions, (void)qualifiers;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                               fmi3Float64 shifts[])
{
    (void)vr, (void)n, (void)shifts;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                fmi3UInt64 counters[], fmi3UInt64 resolutions[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                  const fmi3Float64 intervals[])
{
    (void)vr, (void)n, (void)intervals;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                   const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                               const fmi3Float64 shifts[])
{
    (void)vr, (void)n, (void)shifts;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
{
    (void)vr, (void)n, (void)counters, (void)resolutions;
    ALLOW3(ANY_MODE);
    return absent(self, NO_CLOCKS);
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock,
                                      fmi3Float64 time)
{
    (void)clock, (void)time;
    ALLOW3(ANY_MODE);
    return absent(self, "scheduled execution is not offered");
}
