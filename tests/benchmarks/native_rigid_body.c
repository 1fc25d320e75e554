/* Nanoseconds per RK4 step of the free rigid body: through fmi2DoStep of the FMU's library, through
   set + step + get, and by hand-written C of the same equations in this file.

   Arguments: the library, its GUID. Prints the three numbers, each the best of several rounds. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2Functions.h"

enum { STATES = 13, INPUTS = 12, STEPS = 1000000, ROUNDS = 7 };
static const double STEP = 0.01;
static const double INERTIA[9] = {2.0, 0.1, 0.0, 0.1, 3.0, 0.2, 0.0, 0.2, 4.0}, MASS = 10.0;
static const double INPUT[INPUTS] = {1.0, 2.0, 3.0};
static const double START[STATES] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0.1, 0.2, 0.3};

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return now.tv_sec + 1e-9 * now.tv_nsec;
}

static void cross(const double *a, const double *b, double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void rates(const double *u, double mass, const double *J, const double *x, double *dx)
{
    const double *q = x + 6, *w = x + 10;
    double t[3], s[3], L[3], b[3];
    cross(q, u, t);
    for (int i = 0; i < 3; i++)
        t[i] *= 2.0;
    cross(q, t, s);
    for (int i = 0; i < 3; i++) {
        dx[i] = x[3 + i];
        dx[3 + i] = (u[i] + q[3] * t[i] + s[i] + u[6 + i]) / mass;
        L[i] = J[3 * i] * w[0] + J[3 * i + 1] * w[1] + J[3 * i + 2] * w[2];
    }
    cross(q, w, s);
    for (int i = 0; i < 3; i++)
        dx[6 + i] = 0.5 * (q[3] * w[i] + s[i]);
    dx[9] = -0.5 * (q[0] * w[0] + q[1] * w[1] + q[2] * w[2]);
    cross(L, w, b);
    for (int i = 0; i < 3; i++)
        b[i] += u[3 + i] + u[9 + i];
    double c0[3], c1[3], c2[3]; /* J^-1 b by the adjugate */
    cross(J + 3, J + 6, c0);
    cross(J + 6, J, c1);
    cross(J, J + 3, c2);
    const double determinant = J[0] * c0[0] + J[1] * c0[1] + J[2] * c0[2];
    for (int i = 0; i < 3; i++)
        dx[10 + i] = (c0[i] * b[0] + c1[i] * b[1] + c2[i] * b[2]) / determinant;
}

__attribute__((noinline)) static void step(const double *u, double mass, const double *J,
                                           double *x, double h)
{
    double k1[STATES], k2[STATES], k3[STATES], k4[STATES], y[STATES];
    rates(u, mass, J, x, k1);
    for (int i = 0; i < STATES; i++)
        y[i] = x[i] + 0.5 * h * k1[i];
    rates(u, mass, J, y, k2);
    for (int i = 0; i < STATES; i++)
        y[i] = x[i] + 0.5 * h * k2[i];
    rates(u, mass, J, y, k3);
    for (int i = 0; i < STATES; i++)
        y[i] = x[i] + h * k3[i];
    rates(u, mass, J, y, k4);
    for (int i = 0; i < STATES; i++)
        x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    const double norm = sqrt(x[6] * x[6] + x[7] * x[7] + x[8] * x[8] + x[9] * x[9]);
    for (int i = 6; i < 10; i++)
        x[i] /= norm;
}

#define LOAD(name) name##TYPE *name##_ = (name##TYPE *)dlsym(library, #name)

int main(int count, char **arguments)
{
    void *library = count == 3 ? dlopen(arguments[1], RTLD_NOW) : NULL;
    if (!library)
        return 2;
    LOAD(fmi2Instantiate);
    LOAD(fmi2SetupExperiment);
    LOAD(fmi2EnterInitializationMode);
    LOAD(fmi2ExitInitializationMode);
    LOAD(fmi2SetReal);
    LOAD(fmi2GetReal);
    LOAD(fmi2DoStep);
    fmi2CallbackFunctions callbacks = {NULL, calloc, free, NULL, NULL};
    fmi2Component c =
        fmi2Instantiate_("body", fmi2CoSimulation, arguments[2], "", &callbacks, 0, 0);
    if (!c)
        return 3;
    fmi2ValueReference r[64];
    for (unsigned i = 0; i < 64; i++)
        r[i] = i;
    int bad = fmi2SetReal_(c, r + 1, INPUTS, INPUT) | fmi2SetReal_(c, r + 13, 1, &MASS) |
              fmi2SetReal_(c, r + 14, 9, INERTIA) | fmi2SetReal_(c, r + 23, STATES, START);
    bad |= fmi2SetupExperiment_(c, 0, 0, 0, 0, 0) | fmi2EnterInitializationMode_(c) |
           fmi2ExitInitializationMode_(c);
    double x[STATES], y[STATES], best[3] = {1e9, 1e9, 1e9};
    memcpy(x, START, sizeof x);
    long n = 0;
    for (int round = 0; round < ROUNDS; round++) {
        const double t0 = seconds();
        for (int i = 0; i < STEPS; i++, n++)
            bad |= fmi2DoStep_(c, n * STEP, STEP, 1);
        const double t1 = seconds();
        for (int i = 0; i < STEPS; i++, n++) {
            bad |= fmi2SetReal_(c, r + 1, INPUTS, INPUT);
            bad |= fmi2DoStep_(c, n * STEP, STEP, 1);
            bad |= fmi2GetReal_(c, r + 23, STATES, y);
        }
        const double t2 = seconds();
        for (int i = 0; i < 2 * STEPS; i++)
            step(INPUT, MASS, INERTIA, x, STEP);
        const double t3 = seconds();
        best[0] = fmin(best[0], t1 - t0);
        best[1] = fmin(best[1], t2 - t1);
        best[2] = fmin(best[2], (t3 - t2) / 2.0);
    }
    for (int i = 6; i < STATES; i++)
        bad |= !(fabs(x[i] - y[i]) < 1e-6);
    printf("%g %g %g\n", best[0] / STEPS * 1e9, best[1] / STEPS * 1e9, best[2] / STEPS * 1e9);
    return bad ? 1 : 0;
}
