/* Shared by the files of the FMI 2.0 interface. */
#ifndef SIGHTLINE_FMI2_H
#define SIGHTLINE_FMI2_H

#include "fmi2Functions.h"
#include "instance.h"

/* Refuse a call that the standard does not allow in the present mode; damages nothing. */
#define ALLOW(modes)                                                                               \
    Instance *self = c;                                                                            \
    if (!self || !allowed(self, __func__, modes))                                                  \
        return fmi2Error

static inline fmi2Status status(bool good)
{
    return good ? fmi2OK : fmi2Error;
}

#endif
