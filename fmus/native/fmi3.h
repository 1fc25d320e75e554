/* Shared by the files of the FMI 3.0 interface. */
#ifndef SIGHTLINE_FMI3_H
#define SIGHTLINE_FMI3_H

#include "fmi3Functions.h"
#include "instance.h"

/* Refuse a call that the standard does not allow in the present mode; damages nothing. */
#define ALLOW3(modes)                                                                              \
    Instance *self = instance;                                                                     \
    if (!self || !allowed(self, __func__, modes))                                                  \
        return fmi3Error

static inline fmi3Status status3(bool good)
{
    return good ? fmi3OK : fmi3Error;
}

#endif
