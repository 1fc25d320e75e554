/* Runs an FMI 2.0 co-simulation library without any simulation tool, on any platform.

   loader LIBRARY GUID STEPS STEP {set REFERENCE VALUE | drive REFERENCE START SLOPE | get REFERENCE}

   `set` acts before initialisation; `drive` sets an input to START + SLOPE · k before step k. Prints
   one line per step: the values of all `get`, as hexadecimal floating-point numbers. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2FunctionTypes.h"

#ifdef _WIN32
#include <windows.h>
static void *function(void *library, const char *name)
{
    return (void *)GetProcAddress(library, name);
}
static void *load(const char *path)
{
    return LoadLibraryA(path);
}
#else
#include <dlfcn.h>
static void *function(void *library, const char *name)
{
    return dlsym(library, name);
}
static void *load(const char *path)
{
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}
#endif

enum { MOST = 64 };

static void message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                    fmi2String category, fmi2String text, ...)
{
    va_list arguments;
    va_start(arguments, text);
    fprintf(stderr, "%s: ", category);
    vfprintf(stderr, text, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

static void *find(void *library, const char *name)
{
    void *found = function(library, name);
    if (!found) {
        fprintf(stderr, "the library has no function %s\n", name);
        exit(2);
    }
    return found;
}

static void must(const char *action, fmi2Status status)
{
    if (status != fmi2OK) {
        fprintf(stderr, "%s: status %d\n", action, (int)status);
        exit(1);
    }
}

#define FIND(name) name##TYPE *name = (name##TYPE *)find(library, #name)

int main(int count, char **arguments)
{
    void *library = count > 4 ? load(arguments[1]) : NULL;
    if (!library) {
        fprintf(stderr, "cannot load the library\n");
        return 2;
    }
    FIND(fmi2Instantiate);
    FIND(fmi2SetupExperiment);
    FIND(fmi2EnterInitializationMode);
    FIND(fmi2ExitInitializationMode);
    FIND(fmi2SetReal);
    FIND(fmi2GetReal);
    FIND(fmi2DoStep);
    FIND(fmi2Terminate);
    FIND(fmi2FreeInstance);
    const long steps = strtol(arguments[3], NULL, 10);
    const double h = strtod(arguments[4], NULL);
    fmi2ValueReference inputs[MOST], outputs[MOST];
    double start[MOST], slope[MOST], value[MOST];
    size_t n_inputs = 0, n_outputs = 0;

    const fmi2CallbackFunctions callbacks = {message, calloc, free, NULL, NULL};
    fmi2Component c =
        fmi2Instantiate("one", fmi2CoSimulation, arguments[2], NULL, &callbacks, fmi2False, fmi2True);
    if (!c)
        return 1;
    for (int i = 5; i < count;) {
        const char *verb = arguments[i];
        const fmi2ValueReference reference = (fmi2ValueReference)strtoul(arguments[i + 1], NULL, 10);
        if (strcmp(verb, "set") == 0) {
            const double given = strtod(arguments[i + 2], NULL);
            must("set", fmi2SetReal(c, &reference, 1, &given));
            i += 3;
        } else if (strcmp(verb, "drive") == 0) {
            inputs[n_inputs] = reference;
            start[n_inputs] = strtod(arguments[i + 2], NULL);
            slope[n_inputs++] = strtod(arguments[i + 3], NULL);
            i += 4;
        } else {
            outputs[n_outputs++] = reference;
            i += 2;
        }
    }
    must("setup", fmi2SetupExperiment(c, fmi2False, 0.0, 0.0, fmi2False, 0.0));
    must("enter initialisation", fmi2EnterInitializationMode(c));
    must("leave initialisation", fmi2ExitInitializationMode(c));
    for (long k = 0; k < steps; k++) {
        for (size_t i = 0; i < n_inputs; i++)
            value[i] = start[i] + slope[i] * (double)k;
        must("drive", fmi2SetReal(c, inputs, n_inputs, value));
        must("step", fmi2DoStep(c, (double)k * h, h, fmi2True));
        must("get", fmi2GetReal(c, outputs, n_outputs, value));
        for (size_t i = 0; i < n_outputs; i++)
            printf("%a%c", value[i], i + 1 < n_outputs ? ' ' : '\n');
    }
    must("terminate", fmi2Terminate(c));
    fmi2FreeInstance(c);
    return 0;
}
