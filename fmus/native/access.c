/* Messages about values that cannot be read or written. */
#include "access.h"

#include <math.h>

static const char *const TYPE_NAMES[] = {"real", "integer", "boolean", "enumeration"};

static bool known(Instance *self, uint32_t reference, int type)
{
    if (reference >= N_VALUES || model_access[reference].extent == 0) {
        report(self, STATUS_ERROR, "there is no variable with value reference %u",
               (unsigned)reference);
        return false;
    }
    if (model_access[reference].type != type) {
        report(self, STATUS_ERROR, "%s is of type %s, not %s", model_names[reference],
               TYPE_NAMES[model_access[reference].type], TYPE_NAMES[type]);
        return false;
    }
    return true;
}

bool refuse_read(Instance *self, uint32_t reference, int type)
{
    known(self, reference, type);
    return false;
}

bool refuse_write(Instance *self, uint32_t reference, int type)
{
    if (!known(self, reference, type))
        return false;
    switch (model_access[reference].kind) {
    case TIME: case OUTPUT: case DERIVATIVE:
        report(self, STATUS_ERROR, "%s is calculated and cannot be set", model_names[reference]);
        break;
    default:
        report(self, STATUS_ERROR, "%s cannot be set in this mode", model_names[reference]);
    }
    return false;
}

bool refuse_value(Instance *self, uint32_t element, double value)
{
    const char *name = model_names[element];
    if (!isfinite(value))
        report(self, STATUS_ERROR, "%s = %g: must be finite", name, value);
    else if (value < model_limits[element].min)
        report(self, STATUS_ERROR, "%s = %g: must be at least %g", name, value,
               model_limits[element].min);
    else
        report(self, STATUS_ERROR, "%s = %g: must be at most %g", name, value,
               model_limits[element].max);
    return false;
}

bool refuse_count(Instance *self, size_t given, size_t expected)
{
    report(self, STATUS_ERROR, "%lu values given for variables of %lu elements",
           (unsigned long)given, (unsigned long)expected);
    return false;
}
