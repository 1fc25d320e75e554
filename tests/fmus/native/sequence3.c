/* A full FMI 3.0 call sequence on the block whose sources are included, for sanitizers and
   valgrind: both interfaces, event mode, every kind of function, wrong calls too. */
#include "fmu.c"

#include <stdio.h>
#include <stdlib.h>

static int messages;

static void count_message(fmi3InstanceEnvironment environment, fmi3Status level,
                          fmi3String category, fmi3String message)
{
    (void)environment, (void)level;
    messages += category[0] && message[0];
}

#define CHECK(call)                                                                                \
    do {                                                                                           \
        if ((call) != fmi3OK) {                                                                    \
            fprintf(stderr, "%d: %s\n", __LINE__, #call);                                          \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

static void read_all(fmi3Instance c)
{
    for (fmi3ValueReference r = 0; r < N_VALUES; r++) {
        double real[N_VALUES];
        int32_t integer[N_VALUES];
        int64_t item[N_VALUES];
        bool boolean[N_VALUES];
        const size_t n = model_access[r].extent;
        if (n == 0)
            continue;
        switch (model_access[r].type) {
        case REAL: CHECK(fmi3GetFloat64(c, &r, 1, real, n)); break;
        case BOOLEAN: CHECK(fmi3GetBoolean(c, &r, 1, boolean, n)); break;
        case INTEGER: CHECK(fmi3GetInt32(c, &r, 1, integer, n)); break;
        default: CHECK(fmi3GetInt64(c, &r, 1, item, n));
        }
    }
}

static void derive(fmi3Instance c)
{
    for (fmi3ValueReference u = 1; u < N_VALUES; u++)
        for (fmi3ValueReference k = 0; k < N_KNOWNS; k++) {
            const size_t nu = model_access[u].extent, nk = model_access[k].extent;
            if (nu && nk && (model_access[u].kind == OUTPUT || model_access[u].kind == DERIVATIVE) &&
                model_access[k].type == REAL && model_access[k].kind != FIXED &&
                model_access[k].kind != TUNABLE) {
                double ones[N_VALUES], result[N_VALUES];
                for (int i = 0; i < N_VALUES; i++)
                    ones[i] = 1.0;
                fmi3GetDirectionalDerivative(c, &u, 1, &k, 1, ones, nk, result, nu);
                fmi3GetAdjointDerivative(c, &u, 1, &k, 1, ones, nu, result, nk);
            }
        }
}

static void wrong_calls(fmi3Instance c)
{
    const fmi3ValueReference nowhere[] = {N_VALUES, 0xffffffffu};
    double value = NAN;
    size_t size;
    for (int i = 0; i < 2; i++) {
        fmi3GetFloat64(c, nowhere + i, 1, &value, 1);
        fmi3SetFloat64(c, nowhere + i, 1, &value, 1);
        fmi3GetDirectionalDerivative(c, nowhere + i, 1, nowhere + i, 1, &value, 1, &value, 1);
        fmi3GetAdjointDerivative(c, nowhere + i, 1, nowhere + i, 1, &value, 1, &value, 1);
    }
    for (fmi3ValueReference r = 1; r < N_VALUES; r++)
        fmi3SetFloat64(c, &r, 1, &value, 1);
    fmi3GetNumberOfVariableDependencies(c, 1, &size);
    fmi3ActivateModelPartition(c, 1, 0.0);
    fmi3EnterConfigurationMode(c);
    fmi3DeserializeFMUState(c, (const fmi3Byte *)"rubbish", 7, &(fmi3FMUState){NULL});
}

static fmi3Instance started(bool exchange, bool events)
{
    fmi3Instance c =
        exchange ? fmi3InstantiateModelExchange("one", MODEL_TOKEN, "", 0, 1, NULL, count_message)
                 : fmi3InstantiateCoSimulation("one", MODEL_TOKEN, "", 0, 1, events, events, NULL,
                                               0, NULL, count_message, NULL);
    if (!c)
        exit(1);
    const fmi3ValueReference period = SAMPLE_PERIOD;
    if (SAMPLE_PERIOD)
        CHECK(fmi3SetFloat64(c, &period, 1, &(double){0.07}, 1));
    CHECK(fmi3EnterInitializationMode(c, true, 1e-6, 0.0, false, 0.0));
    read_all(c);
    derive(c);
    CHECK(fmi3ExitInitializationMode(c));
    return c;
}

static bool update(fmi3Instance c)
{
    bool again, end, nominals, values, defined;
    double next;
    do
        CHECK(fmi3UpdateDiscreteStates(c, &again, &end, &nominals, &values, &defined, &next));
    while (again);
    return values;
}

static void co_simulation(bool events)
{
    fmi3Instance c = started(false, events);
    fmi3FMUState state = NULL, copy = NULL;
    bool event, end, early;
    size_t size;
    double time = 0.0;
    if (events) {
        update(c);
        CHECK(fmi3EnterStepMode(c));
    }
    for (int k = 0; k < 20; k++) {
        CHECK(fmi3DoStep(c, time, 0.05, true, &event, &end, &early, &time));
        if (event && events) {
            CHECK(fmi3EnterEventMode(c));
            CHECK(fmi3EvaluateDiscreteStates(c));
            update(c);
            CHECK(fmi3EnterStepMode(c));
        }
        read_all(c);
        derive(c);
    }
    CHECK(fmi3GetFMUState(c, &state));
    wrong_calls(c);
    CHECK(fmi3SerializedFMUStateSize(c, state, &size));
    fmi3Byte *bytes = malloc(size);
    CHECK(fmi3SerializeFMUState(c, state, bytes, size));
    CHECK(fmi3DeserializeFMUState(c, bytes, size, &copy));
    CHECK(fmi3SetFMUState(c, copy));
    CHECK(fmi3DoStep(c, time, 0.5, true, &event, &end, &early, &time));
    CHECK(fmi3FreeFMUState(c, &state));
    CHECK(fmi3FreeFMUState(c, &copy));
    free(bytes);
    CHECK(fmi3Terminate(c));
    CHECK(fmi3Reset(c));
    fmi3FreeInstance(c);
}

static void model_exchange(void)
{
    fmi3Instance c = started(true, false);
    double x[SOME(N_STATES)], dx[SOME(N_STATES)];
    bool event, end;
    update(c);
    for (int k = 1; k <= 20; k++) {
        CHECK(fmi3EnterContinuousTimeMode(c));
        CHECK(fmi3GetContinuousStates(c, x, N_STATES));
        CHECK(fmi3GetContinuousStateDerivatives(c, dx, N_STATES));
        for (int i = 0; i < N_STATES; i++)
            x[i] += 0.001 * dx[i];
        CHECK(fmi3SetTime(c, 0.07 * k));
        CHECK(fmi3SetContinuousStates(c, x, N_STATES));
        CHECK(fmi3CompletedIntegratorStep(c, true, &event, &end));
        read_all(c);
        CHECK(fmi3EnterEventMode(c));
        update(c);
    }
    CHECK(fmi3GetNominalsOfContinuousStates(c, x, N_STATES));
    wrong_calls(c);
    CHECK(fmi3Terminate(c));
    fmi3FreeInstance(c);
}

int main(void)
{
    co_simulation(false);
    co_simulation(true);
    model_exchange();
    fmi3InstantiateScheduledExecution("one", MODEL_TOKEN, "", 0, 0, NULL, count_message, NULL,
                                      NULL, NULL);
    return messages > 0 ? 0 : 2;
}
