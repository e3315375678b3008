/* A vehicle as a co-simulation unit of FMI 3.0 and 2.0: numbers in, steps, numbers out.
 *
 * The build gives the vehicle's workspace as wrsim_fmu (index, then buffer, see wrsim.jit.arena), and writes fmu.h:
 * where in the buffer each variable is, and their names. All that changes is in the buffer, so a state is a copy of it.
 * Signatures are those of fmi3Functions.h, version 3.0, and of fmi2Functions.h, version 2.0. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "runtime.h"
#include "fmu.h"

#define PART 1e-6 /* of a step: a communication step may miss a whole number of steps by so much */

enum { OK = 0, ERROR = 3 };
enum { INSTANTIATED, INITIALIZATION, STEPS, TERMINATED, FAILED };
static const char *const modes[] = {"instantiated", "in initialization", "in step mode", "terminated", "failed"};

extern HIDDEN const int64_t wrsim_fmu[];

/* What a state consists of. */
struct memory {
    char token[40];
    double start; /* time at the beginning [s] */
    int64_t mode;
    _Alignas(ALIGNMENT) double numbers[DOUBLES];
};

typedef void (*fmi2_log)(void *, const char *, int, const char *, const char *, ...);

struct instance {
    struct memory *memory;
    void *environment;
    void (*log)(void *, int, const char *, const char *);
    fmi2_log log2; /* the same of FMI 2 */
    char name[100];
    char text[300];
};

static double time_of(const struct memory *m)
{
    int64_t done;
    memcpy(&done, m->numbers + STEPS_DONE, sizeof done);
    return m->start + STEP * (double)done;
}

/* Report an error; returns its status. A text that begins with the name of a function has that of the version. */
static int fail(struct instance *one, const char *format, const char *name, double number)
{
    if (!one) return ERROR;
    snprintf(one->text, sizeof one->text, format, name, number);
    if (one->log2 && strncmp(one->text, "fmi3", 4) == 0) one->text[3] = '2';
    if (one->log) one->log(one->environment, ERROR, "logStatusError", one->text);
    if (one->log2) { /* takes a format: not all who log read what follows it */
        char doubled[2 * sizeof one->text], *to = doubled;
        for (const char *from = one->text; *from; from++)
            if ((*to++ = *from) == '%') *to++ = '%';
        *to = 0;
        one->log2(one->environment, one->name, ERROR, "logStatusError", doubled);
    }
    return ERROR;
}

static void set_up(struct memory *m)
{
    memcpy(m->token, TOKEN, sizeof TOKEN);
    memcpy(m->numbers, wrsim_fmu + 4 * ROWS, sizeof m->numbers);
    m->start = 0.0;
    m->mode = INSTANTIATED;
}

static struct memory *copy_of(const struct memory *from)
{
    struct memory *m = take(sizeof *m);
    if (m && from) memcpy(m, from, sizeof *m);
    return m;
}

/* Whether the instance is in a mode; else the call is reported as an error. */
static bool is_in(struct instance *one, int least, int most, const char *call)
{
    if (one && one->memory->mode >= least && one->memory->mode <= most) return true;
    if (one) fail(one, call, modes[one->memory->mode], 0.0);
    return false;
}

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

/* A new instance; told: who reports errors, copied. */
static void *instantiate(const char *token, const struct instance *told)
{
    struct instance *one = calloc(1, sizeof *one);
    if (!one) return NULL;
    *one = *told;
    if (!token || strcmp(token, TOKEN) != 0)
        fail(one, "the instantiation token is not that of this unit, " TOKEN "%s", "", 0.0);
    else if (!(one->memory = copy_of(NULL)))
        fail(one, "there is not enough memory%s", "", 0.0);
    if (!one->memory) {
        free(one);
        return NULL;
    }
    set_up(one->memory);
    return one;
}

EXPORT void *fmi3InstantiateCoSimulation(
    const char *name, const char *token, const char *resources, bool visible, bool logging, bool events, bool early,
    const uint32_t required[], size_t count, void *environment, void (*log)(void *, int, const char *, const char *),
    void *update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early, (void)required, (void)count;
    (void)update;
    return instantiate(token, &(struct instance){.environment = environment, .log = log});
}

EXPORT void fmi3FreeInstance(struct instance *one)
{
    if (one) give(one->memory);
    free(one);
}

EXPORT int fmi3SetDebugLogging(struct instance *one, bool on, size_t count, const char *const categories[])
{
    (void)on, (void)count, (void)categories;
    return one ? OK : ERROR;
}

EXPORT int fmi3EnterInitializationMode(
    struct instance *one, bool with_tolerance, double tolerance, double start, bool with_stop, double stop)
{
    (void)with_tolerance, (void)tolerance, (void)with_stop, (void)stop;
    if (!is_in(one, INSTANTIATED, INSTANTIATED, "fmi3EnterInitializationMode: the unit is %s")) return ERROR;
    if (!isfinite(start)) return fail(one, "fmi3EnterInitializationMode: startTime %smust be a finite number", "", 0.0);
    one->memory->start = start;
    one->memory->mode = INITIALIZATION;
    return OK;
}

EXPORT int fmi3ExitInitializationMode(struct instance *one)
{
    if (!is_in(one, INITIALIZATION, INITIALIZATION, "fmi3ExitInitializationMode: the unit is %s")) return ERROR;
    one->memory->mode = STEPS;
    return OK;
}

EXPORT int fmi3Terminate(struct instance *one)
{
    if (!is_in(one, STEPS, STEPS, "fmi3Terminate: the unit is %s")) return ERROR;
    one->memory->mode = TERMINATED;
    return OK;
}

EXPORT int fmi3Reset(struct instance *one)
{
    if (!one) return ERROR;
    set_up(one->memory);
    return OK;
}

EXPORT int fmi3GetFloat64(struct instance *one, const uint32_t which[], size_t count, double values[], size_t room)
{
    if (!is_in(one, INSTANTIATED, FAILED, "") || (count && (!which || !values)) || room < count) return ERROR;
    for (size_t i = 0; i < count; i++) {
        if (which[i] >= VARIABLES) return fail(one, "%s: there is no variable %.0f", one->log2 ? "fmi2GetReal" : "fmi3GetFloat64", which[i]);
        values[i] = which[i] ? one->memory->numbers[places[which[i]]] : time_of(one->memory);
    }
    return OK;
}

EXPORT int fmi3SetFloat64(struct instance *one, const uint32_t which[], size_t count, const double values[], size_t room)
{
    if (!is_in(one, INSTANTIATED, STEPS, "the unit is %s: it takes no values")) return ERROR;
    if ((count && (!which || !values)) || room < count) return ERROR;
    for (size_t i = 0; i < count; i++) {
        if (which[i] >= VARIABLES) return fail(one, "%s: there is no variable %.0f", one->log2 ? "fmi2SetReal" : "fmi3SetFloat64", which[i]);
        if (which[i] < 1 || which[i] > INPUTS) return fail(one, "%s: is no input", names[which[i]], 0.0);
        if (!isfinite(values[i])) return fail(one, "%s: must be a finite number, not %g", names[which[i]], values[i]);
    }
    for (size_t i = 0; i < count; i++) one->memory->numbers[places[which[i]]] = values[i];
    return OK;
}

EXPORT int fmi3DoStep(struct instance *one, double point, double size, bool no_set, bool *event, bool *terminate,
                      bool *early, double *last)
{
    double steps = round(size / STEP);
    (void)no_set;
    if (event) *event = false;
    if (terminate) *terminate = false;
    if (early) *early = false;
    if (!is_in(one, STEPS, STEPS, "fmi3DoStep: the unit is %s")) return ERROR;
    struct memory *m = one->memory;
    if (last) *last = time_of(m);
    if (!(fabs(point - time_of(m)) < 0.5 * STEP))
        return fail(one, "fmi3DoStep: %sthe unit is at the time %.9g s", "", time_of(m));
    if (!(steps >= 1.0 && fabs(size - STEP * steps) <= PART * STEP))
        return fail(one, "fmi3DoStep: %sthe communication step must be a whole number of steps of %g s", "", STEP);
    for (; steps >= 1.0; steps--) {
        int64_t status = run(ADVANCE, m->numbers, DOUBLES, wrsim_fmu, ROWS, NOT_FINITE);
        if (status != NOT_FINITE && !(status & OFF_TRACK) && steps < 2.0)
            status |= run(OBSERVE, m->numbers, DOUBLES, wrsim_fmu, ROWS, NOT_FINITE);
        if (status != NOT_FINITE && !(status & OFF_TRACK)) continue;
        m->mode = FAILED;
        return fail(one, status == NOT_FINITE ? "%sa force is not a number at t = %.6g s"
                                              : "%sderailed: the vehicle is no longer near its track at t = %.6g s",
                    "", time_of(m));
    }
    if (last) *last = time_of(m);
    return OK;
}

EXPORT int fmi3GetFMUState(struct instance *one, struct memory **state)
{
    if (!one || !state) return ERROR;
    if (*state)
        memcpy(*state, one->memory, sizeof **state);
    else
        *state = copy_of(one->memory);
    return *state ? OK : fail(one, "there is not enough memory%s", "", 0.0);
}

/* Whether these bytes may be a state: token, mode and start are checked, numbers are those of the unit. */
static bool is_state(const void *bytes)
{
    struct memory head;
    memcpy(&head, bytes, offsetof(struct memory, numbers));
    return memcmp(head.token, TOKEN, sizeof TOKEN) == 0 && isfinite(head.start) && head.mode >= INSTANTIATED &&
           head.mode <= FAILED;
}

EXPORT int fmi3SetFMUState(struct instance *one, const struct memory *state)
{
    if (!one || !state) return ERROR;
    if (!is_state(state)) return fail(one, "fmi3SetFMUState: %sthis is no state of this unit", "", 0.0);
    memcpy(one->memory, state, sizeof *state);
    return OK;
}

EXPORT int fmi3FreeFMUState(struct instance *one, struct memory **state)
{
    (void)one;
    if (state) {
        give(*state);
        *state = NULL;
    }
    return OK;
}

EXPORT int fmi3SerializedFMUStateSize(struct instance *one, const struct memory *state, size_t *size)
{
    if (!one || !state || !size) return ERROR;
    *size = sizeof *state;
    return OK;
}

EXPORT int fmi3SerializeFMUState(struct instance *one, const struct memory *state, uint8_t bytes[], size_t size)
{
    if (!one || !state || !bytes || size < sizeof *state) return ERROR;
    memcpy(bytes, state, sizeof *state);
    return OK;
}

EXPORT int fmi3DeserializeFMUState(struct instance *one, const uint8_t bytes[], size_t size, struct memory **state)
{
    if (!one || !bytes || !state) return ERROR;
    if (size != sizeof **state || !is_state(bytes))
        return fail(one, "fmi3DeserializeFMUState: %sthe bytes are no state of this unit", "", 0.0);
    if (!*state && !(*state = copy_of(NULL))) return fail(one, "there is not enough memory%s", "", 0.0);
    memcpy(*state, bytes, size);
    return OK;
}

EXPORT void *fmi3InstantiateModelExchange(void) { return NULL; }
EXPORT void *fmi3InstantiateScheduledExecution(void) { return NULL; }

/* What modelDescription.xml does not offer: an error with the function's name. */
#define REFUSE_CALL(name) \
    EXPORT int name(struct instance *one) { return fail(one, "%s: is not offered by this unit", #name, 0.0); }
#define REFUSE(name) REFUSE_CALL(fmi3##name)
#define REFUSE_TYPE(type) REFUSE(Get##type) REFUSE(Set##type)
REFUSE_TYPE(Float32) REFUSE_TYPE(Int8) REFUSE_TYPE(UInt8) REFUSE_TYPE(Int16) REFUSE_TYPE(UInt16) REFUSE_TYPE(Int32)
REFUSE_TYPE(UInt32) REFUSE_TYPE(Int64) REFUSE_TYPE(UInt64) REFUSE_TYPE(Boolean) REFUSE_TYPE(String) REFUSE_TYPE(Binary)
REFUSE_TYPE(Clock) REFUSE_TYPE(IntervalDecimal) REFUSE_TYPE(IntervalFraction) REFUSE_TYPE(ShiftDecimal)
REFUSE_TYPE(ShiftFraction) REFUSE_TYPE(ContinuousStates)
REFUSE(GetNumberOfVariableDependencies) REFUSE(GetVariableDependencies) REFUSE(GetDirectionalDerivative)
REFUSE(GetAdjointDerivative) REFUSE(EnterConfigurationMode) REFUSE(ExitConfigurationMode) REFUSE(EnterEventMode)
REFUSE(EvaluateDiscreteStates) REFUSE(UpdateDiscreteStates) REFUSE(EnterContinuousTimeMode) REFUSE(EnterStepMode)
REFUSE(CompletedIntegratorStep) REFUSE(SetTime) REFUSE(GetContinuousStateDerivatives) REFUSE(GetEventIndicators)
REFUSE(GetNominalsOfContinuousStates) REFUSE(GetNumberOfEventIndicators) REFUSE(GetNumberOfContinuousStates)
REFUSE(GetOutputDerivatives) REFUSE(ActivateModelPartition)

/* FMI 2.0: the same unit under other names. */
struct fmi2_callbacks {
    fmi2_log log;
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*finished)(void *, int);
    void *environment;
};
enum { DISCARD = 2, CO_SIMULATION = 1, LAST_SUCCESSFUL_TIME = 2, IS_TERMINATED = 3 };

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources,
                             const struct fmi2_callbacks *functions, int visible, int logging)
{
    struct instance told = {0};
    (void)resources, (void)visible, (void)logging;
    if (functions) told.environment = functions->environment, told.log2 = functions->log;
    snprintf(told.name, sizeof told.name, "%s", name ? name : "");
    if (kind == CO_SIMULATION) return instantiate(guid, &told);
    fail(&told, "fmi2Instantiate: %sthis unit is for co-simulation only", "", 0.0);
    return NULL;
}

EXPORT void fmi2FreeInstance(struct instance *one) { fmi3FreeInstance(one); }

EXPORT int fmi2SetDebugLogging(struct instance *one, int on, size_t count, const char *const categories[])
{
    return fmi3SetDebugLogging(one, on != 0, count, categories);
}

EXPORT int fmi2SetupExperiment(struct instance *one, int with_tolerance, double tolerance, double start, int with_stop,
                               double stop)
{
    (void)with_tolerance, (void)tolerance, (void)with_stop, (void)stop;
    if (!is_in(one, INSTANTIATED, INSTANTIATED, "fmi2SetupExperiment: the unit is %s")) return ERROR;
    if (!isfinite(start)) return fail(one, "fmi2SetupExperiment: startTime %smust be a finite number", "", 0.0);
    one->memory->start = start;
    return OK;
}

EXPORT int fmi2EnterInitializationMode(struct instance *one)
{
    return one ? fmi3EnterInitializationMode(one, false, 0.0, one->memory->start, false, 0.0) : ERROR;
}

EXPORT int fmi2ExitInitializationMode(struct instance *one) { return fmi3ExitInitializationMode(one); }
EXPORT int fmi2Terminate(struct instance *one) { return fmi3Terminate(one); }
EXPORT int fmi2Reset(struct instance *one) { return fmi3Reset(one); }

EXPORT int fmi2GetReal(struct instance *one, const uint32_t which[], size_t count, double values[])
{
    return fmi3GetFloat64(one, which, count, values, count);
}

EXPORT int fmi2SetReal(struct instance *one, const uint32_t which[], size_t count, const double values[])
{
    return fmi3SetFloat64(one, which, count, values, count);
}

EXPORT int fmi2DoStep(struct instance *one, double point, double size, int no_set)
{
    return fmi3DoStep(one, point, size, no_set != 0, NULL, NULL, NULL, NULL);
}

/* A step is never pending: there are the time of the last one, and whether the unit wants to end, which it never does. */
EXPORT int fmi2GetRealStatus(struct instance *one, int kind, double *value)
{
    if (!one || !value || kind != LAST_SUCCESSFUL_TIME) return one && value ? DISCARD : ERROR;
    *value = time_of(one->memory);
    return OK;
}

EXPORT int fmi2GetBooleanStatus(struct instance *one, int kind, int *value)
{
    if (!one || !value || kind != IS_TERMINATED) return one && value ? DISCARD : ERROR;
    *value = 0;
    return OK;
}

#define NO_STATUS(type) \
    EXPORT int fmi2Get##type(struct instance *one) { return one ? DISCARD : ERROR; }
NO_STATUS(Status) NO_STATUS(IntegerStatus) NO_STATUS(StringStatus)

EXPORT int fmi2GetFMUstate(struct instance *one, struct memory **state) { return fmi3GetFMUState(one, state); }
EXPORT int fmi2SetFMUstate(struct instance *one, struct memory *state) { return fmi3SetFMUState(one, state); }
EXPORT int fmi2FreeFMUstate(struct instance *one, struct memory **state) { return fmi3FreeFMUState(one, state); }

EXPORT int fmi2SerializedFMUstateSize(struct instance *one, struct memory *state, size_t *size)
{
    return fmi3SerializedFMUStateSize(one, state, size);
}

EXPORT int fmi2SerializeFMUstate(struct instance *one, struct memory *state, uint8_t bytes[], size_t size)
{
    return fmi3SerializeFMUState(one, state, bytes, size);
}

EXPORT int fmi2DeSerializeFMUstate(struct instance *one, const uint8_t bytes[], size_t size, struct memory **state)
{
    return fmi3DeserializeFMUState(one, bytes, size, state);
}

#define REFUSE2(name) REFUSE_CALL(fmi2##name)
REFUSE2(GetInteger) REFUSE2(SetInteger) REFUSE2(GetBoolean) REFUSE2(SetBoolean) REFUSE2(GetString) REFUSE2(SetString)
REFUSE2(GetDirectionalDerivative) REFUSE2(SetRealInputDerivatives) REFUSE2(GetRealOutputDerivatives) REFUSE2(CancelStep)

#ifdef __wasm__
/* The numbers of an instance, for a page that shows and changes them. */
EXPORT double *wrsim_numbers(struct instance *one) { return one->memory->numbers; }
#endif
