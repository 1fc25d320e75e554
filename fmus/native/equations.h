/* What the generated file equations.c provides: tables and equations of one block. */
#ifndef SIGHTLINE_EQUATIONS_H
#define SIGHTLINE_EQUATIONS_H

#include <stdint.h>

#include "model.h"

#if defined __GNUC__ && !defined _WIN32
#pragma GCC visibility push(hidden) /* only the functions of FMI are visible outside */
#endif

#define SOME(n) ((n) > 0 ? (n) : 1) /* C has no empty arrays */

typedef enum { REAL, INTEGER, BOOLEAN, ENUMERATION } Type;
typedef enum {
    TIME, INPUT, FIXED, TUNABLE, STATE, DISCRETE_STATE, OUTPUT, DERIVATIVE
} Kind;

typedef struct {
    uint8_t type;
    uint8_t kind;
    uint8_t is_output; /* a port, whether computed or a state */
    uint8_t unused;
    uint32_t extent;   /* scalars behind this value reference; 0: not a value reference */
    uint32_t run;      /* scalars from here on that are references of their own and of one kind */
} Access;

typedef struct {
    double min, max; /* finite, so that they exclude infinity */
} Limits;

extern const Access model_access[N_VALUES];
extern const Limits model_limits[N_VALUES];
extern const double model_start[N_VALUES];
extern const double model_nominal[SOME(N_STATES)];
extern const char *const model_names[N_VALUES];
extern const char *const model_requirements[SOME(N_REQUIREMENTS)];
extern const int model_noise_sizes[SOME(N_CHANNELS)];

/* `v`: the array of values, of which inputs, parameters and discrete states are read. */
void model_derivatives(double t, const double *v, const double *x, double *rates);
void model_outputs(const double *v, const double *noise, double *outputs);
void model_update(const double *v, const double *noise, double *discrete);
void model_project(double t, const double *v, const double *x, double *projected);
void model_require(const double *v, double *holds);
/* Seeds and sensitivities of time, inputs, parameters, states, discrete states, in this order. */
void model_derivatives_forward(const double *v, const double *seed, double *tangent);
void model_derivatives_reverse(const double *v, const double *seed, double *adjoint);
void model_outputs_forward(const double *v, const double *w, const double *seed, double *tangent);
void model_outputs_reverse(const double *v, const double *w, const double *seed, double *adjoint);

#if defined __GNUC__ && !defined _WIN32
#pragma GCC visibility pop
#endif

#endif
