/* A full FMI 2.0 call sequence on the block whose sources are included, for sanitizers and
   valgrind: both interfaces, every kind of function, wrong calls too. Returns 0 if all is well. */
#include "fmu.c"

#include <stdio.h>
#include <stdlib.h>

static int messages;

static void count_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status level,
                          fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name, (void)level;
    messages += category[0] && message[0];
}

static fmi2CallbackFunctions callbacks = {count_message, calloc, free, NULL, NULL};

#define CHECK(call)                                                                                \
    do {                                                                                           \
        if ((call) != fmi2OK) {                                                                    \
            fprintf(stderr, "%d: %s\n", __LINE__, #call);                                          \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

static void read_all(fmi2Component c)
{
    for (fmi2ValueReference r = 1; r < N_VALUES; r++) {
        fmi2Real real;
        fmi2Integer integer;
        fmi2Boolean boolean;
        switch (model_access[r].type) {
        case REAL: CHECK(fmi2GetReal(c, &r, 1, &real)); break;
        case BOOLEAN: CHECK(fmi2GetBoolean(c, &r, 1, &boolean)); break;
        default: CHECK(fmi2GetInteger(c, &r, 1, &integer));
        }
    }
}

static void set_inputs(fmi2Component c)
{
    for (fmi2ValueReference r = INPUTS; r < INPUTS + N_INPUTS; r++)
        if (model_access[r].type == REAL)
            CHECK(fmi2SetReal(c, &r, 1, &model_start[r]));
}

static void derive(fmi2Component c)
{
    for (fmi2ValueReference u = 1; u < N_VALUES; u++)
        for (fmi2ValueReference k = 1; k < N_KNOWNS; k++)
            if ((model_access[u].kind == OUTPUT || model_access[u].kind == DERIVATIVE) &&
                model_access[k].type == REAL && model_access[k].kind != FIXED &&
                model_access[k].kind != TUNABLE) {
                const fmi2Real seed = 1.0;
                fmi2Real result;
                fmi2GetDirectionalDerivative(c, &u, 1, &k, 1, &seed, &result);
            }
}

static void wrong_calls(fmi2Component c)
{
    const fmi2ValueReference nowhere[] = {N_VALUES, 0xffffffffu};
    const fmi2Real nan = NAN;
    const fmi2Integer order = 1;
    fmi2Real value;
    fmi2Integer integer;
    fmi2String text;
    for (int i = 0; i < 2; i++) {
        fmi2GetReal(c, nowhere + i, 1, &value);
        fmi2SetReal(c, nowhere + i, 1, &value);
        fmi2GetInteger(c, nowhere + i, 1, &integer);
        fmi2SetRealInputDerivatives(c, nowhere + i, 1, &order, &value);
        fmi2GetDirectionalDerivative(c, nowhere + i, 1, nowhere + i, 1, &nan, &value);
    }
    fmi2GetString(c, nowhere, 1, &text);
    for (fmi2ValueReference r = 1; r < N_VALUES; r++)
        fmi2SetReal(c, &r, 1, &nan);
    fmi2CancelStep(c);
    fmi2EnterInitializationMode(c);
    fmi2DeSerializeFMUstate(c, "rubbish", 7, &(fmi2FMUstate){NULL});
}

static fmi2Component started(fmi2Type type)
{
    fmi2Component c = fmi2Instantiate("one", type, MODEL_TOKEN, "", &callbacks, 0, 1);
    if (!c)
        exit(1);
    CHECK(fmi2SetupExperiment(c, 1, 1e-6, 0.0, 0, 0.0));
    const fmi2ValueReference period = SAMPLE_PERIOD;
    if (SAMPLE_PERIOD)
        CHECK(fmi2SetReal(c, &period, 1, &(fmi2Real){0.07}));
    CHECK(fmi2EnterInitializationMode(c));
    read_all(c);
    derive(c);
    CHECK(fmi2ExitInitializationMode(c));
    return c;
}

static void co_simulation(int solver)
{
    fmi2Component c = started(fmi2CoSimulation);
    fmi2FMUstate state = NULL, copy = NULL;
    size_t size;
    ((Instance *)c)->s.v[SOLVER ? SOLVER : 0] = SOLVER ? solver : 0.0;
    for (int k = 0; k < 20; k++) {
        set_inputs(c);
        CHECK(fmi2DoStep(c, k * 0.05, 0.05, fmi2True));
        read_all(c);
        derive(c);
        if (k == 10)
            CHECK(fmi2GetFMUstate(c, &state));
    }
    wrong_calls(c);
    CHECK(fmi2SerializedFMUstateSize(c, state, &size));
    fmi2Byte *bytes = malloc(size);
    CHECK(fmi2SerializeFMUstate(c, state, bytes, size));
    CHECK(fmi2DeSerializeFMUstate(c, bytes, size, &copy));
    CHECK(fmi2SetFMUstate(c, copy));
    CHECK(fmi2DoStep(c, 0.55, 1.0, fmi2True));
    CHECK(fmi2FreeFMUstate(c, &state));
    CHECK(fmi2FreeFMUstate(c, &copy));
    free(bytes);
    CHECK(fmi2Terminate(c));
    CHECK(fmi2Reset(c));
    fmi2FreeInstance(c);
}

static void model_exchange(void)
{
    fmi2Component c = started(fmi2ModelExchange);
    double x[SOME(N_STATES)], dx[SOME(N_STATES)];
    fmi2EventInfo info;
    fmi2Boolean event, end;
    CHECK(fmi2NewDiscreteStates(c, &info));
    for (int k = 1; k <= 20; k++) {
        CHECK(fmi2EnterContinuousTimeMode(c));
        CHECK(fmi2GetContinuousStates(c, x, N_STATES));
        CHECK(fmi2GetDerivatives(c, dx, N_STATES));
        CHECK(fmi2GetEventIndicators(c, NULL, 0));
        for (int i = 0; i < N_STATES; i++)
            x[i] += 0.001 * dx[i];
        CHECK(fmi2SetTime(c, 0.07 * k));
        CHECK(fmi2SetContinuousStates(c, x, N_STATES));
        set_inputs(c);
        CHECK(fmi2CompletedIntegratorStep(c, fmi2True, &event, &end));
        read_all(c);
        CHECK(fmi2EnterEventMode(c));
        do
            CHECK(fmi2NewDiscreteStates(c, &info));
        while (info.newDiscreteStatesNeeded);
    }
    CHECK(fmi2GetNominalsOfContinuousStates(c, x, N_STATES));
    wrong_calls(c);
    CHECK(fmi2Terminate(c));
    fmi2FreeInstance(c);
}

int main(void)
{
    co_simulation(1);
    co_simulation(2);
    model_exchange();
    fmi2Instantiate("one", fmi2CoSimulation, "another token", "", &callbacks, 0, 1);
    return messages > 0 ? 0 : 2;
}
