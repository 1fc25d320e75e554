/* One simulated instance of a block: its values, modes and the operations on it.

   FMI-independent core; fmi2*.c and fmi3*.c put the standards' interfaces on top. All values stand
   in one array, an FMI value reference is the index into it, the sections are those of model.h. */
#ifndef SIGHTLINE_INSTANCE_H
#define SIGHTLINE_INSTANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "equations.h"

#if defined __GNUC__ && !defined _WIN32
#pragma GCC visibility push(hidden) /* only the functions of FMI are visible outside */
#endif

typedef enum { STATUS_WARNING = 1, STATUS_DISCARD, STATUS_ERROR, STATUS_FATAL } Severity;
enum { CATEGORY_ALL = 0x1f };  /* bit s: category of severity s; bit 0: everything else */

typedef enum { MODEL_EXCHANGE, CO_SIMULATION } Interface;

typedef enum {
    INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, STEP = 16, TERMINATED = 32,
    FAILED = 64,
    RUNNING = EVENT | CONTINUOUS | STEP,
    READABLE = INITIALIZATION | RUNNING | TERMINATED | FAILED,
    ANY_MODE = 127
} Mode;

enum { OUTPUTS_STALE = 1, RATES_STALE = 2, ALL_STALE = 3 };

/* Everything that later results depend on: what an FMU state saves, bit for bit. What every step
   uses stands first, close together: of a thousand instances little else passes through caches. */
typedef struct {
    int32_t mode;
    int32_t stale;
    int32_t pending;       /* the tick falls on the present instant and is not final yet */
    int32_t evaluated;     /* outputs and next_discrete are those of the pending tick */
    int32_t extrapolated;  /* inputs have derivatives in the coming step */
    int32_t stop_defined;
    double start_time;
    double stop_time;
    int64_t tick;          /* index of the next tick, or of the pending one */
    double v[N_VALUES];
    double proposal;       /* step that Dormand-Prince tries first */
    double next_discrete[SOME(N_DISCRETE)];  /* of the pending tick, once evaluated */
    double noise[SOME(N_NOISE)];             /* draws of the tick evaluated last */
    double base[SOME(N_INPUTS)];             /* inputs at the start of the step, */
    double slope[SOME(N_INPUTS)];            /* and their first and second derivatives */
    double curvature[SOME(N_INPUTS)];
    double base_time;
    uint64_t stream;       /* hash of the instance's name */
    int32_t interface;
    int32_t unused;
} State;

typedef struct Instance Instance;
struct Instance {
    State s;
    /* the environment */
    void (*emit)(Instance *self, Severity severity, const char *category, const char *message);
    void (*logger)(void);
    void *environment;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
    unsigned categories;  /* switched on */
    int event_mode_used;
    int early_return_allowed;
    char name[];
};

typedef struct {
    double reached;
    bool event;  /* a tick falls on `reached` */
    bool early;
} Progress;

/* instance.c */
Instance *create(const char *name, const char *token, Interface interface,
                 void *(*allocate)(size_t, size_t), void (*release)(void *));
const char *why_not_created(const char *name, const char *token);
void to_start(Instance *self);
bool allowed(Instance *self, const char *function, int modes);
void report(Instance *self, Severity severity, const char *format, ...);
bool choose_categories(Instance *self, bool on, size_t count, const char *const names[]);
bool enter_initialization(Instance *self, double start_time);
bool exit_initialization(Instance *self, Mode next);

/* evaluate.c */
bool refresh_outputs(Instance *self);
bool refresh_rates(Instance *self);
bool evaluate_tick(Instance *self);
bool depart(Instance *self);
bool requirements_hold(Instance *self);
bool name_not_finite(Instance *self, const double *values, int count, int first);
bool all_finite(const double *values, int count);

/* events.c */
double period(const Instance *self);
double tick_time(const Instance *self);
double tick_tolerance(const Instance *self, double time);
bool enter_event_mode(Instance *self);
bool completed_step(Instance *self, bool *enter_event_mode);

typedef struct {
    bool again, values_changed, next_defined;
    double next_time;
} EventUpdate;
bool update_discrete_states(Instance *self, EventUpdate *update);

/* exchange.c */
bool set_time(Instance *self, double time);
bool set_states(Instance *self, const double *x, size_t n);
bool get_states(Instance *self, double *x, size_t n);
bool get_rates(Instance *self, double *rates, size_t n);
bool get_nominals(Instance *self, double *nominals, size_t n);

/* integrate.c, step.c */
void extrapolate_inputs(Instance *self, double time);
bool integrate(Instance *self, double end);
bool do_step(Instance *self, double time, double h, bool stop_at_ticks, Progress *progress);

/* noise.c */
uint64_t stream_of(const char *name);
void draw_noise(Instance *self);

/* snapshot.c */
bool save_state(Instance *self, void **snapshot);
bool restore_state(Instance *self, const void *snapshot);
void free_state(Instance *self, void **snapshot);
size_t serialized_size(void);
bool serialize_state(Instance *self, const void *snapshot, unsigned char *bytes, size_t size);
bool deserialize_state(Instance *self, const unsigned char *bytes, size_t size, void **snapshot);

/* sensitivity.c */
bool directional_derivative(Instance *self, const uint32_t *unknowns, size_t n_unknowns,
                            const uint32_t *knowns, size_t n_knowns, const double *seed,
                            size_t n_seed, double *result, size_t n_result);
bool adjoint_derivative(Instance *self, const uint32_t *unknowns, size_t n_unknowns,
                        const uint32_t *knowns, size_t n_knowns, const double *seed,
                        size_t n_seed, double *result, size_t n_result);

/* access.c */
bool refuse_read(Instance *self, uint32_t reference, int type);
bool refuse_write(Instance *self, uint32_t reference, int type);
bool refuse_value(Instance *self, uint32_t element, double value);
bool refuse_count(Instance *self, size_t given, size_t expected);

#if defined __GNUC__ && !defined _WIN32
#pragma GCC visibility pop
#endif

#endif
