/* Plays a unit of FMI 3.0: player LIBRARY TOKEN FIRST COUNT STEPS EVERY. A line of outputs after every EVERY steps. */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define STEP 1e-3

typedef void *make(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *, size_t, void *,
                   void *, void *);
typedef int enter(void *, bool, double, double, bool, double);
typedef int leave(void *);
typedef int do_step(void *, double, double, bool, void *, void *, void *, void *);
typedef int get(void *, const uint32_t *, size_t, double *, size_t);

int main(int count, char **words)
{
    void *library = count == 7 ? dlopen(words[1], RTLD_NOW) : NULL, *unit;
    if (!library) return fprintf(stderr, "%s\n", dlerror()), 1;
    int first = atoi(words[3]), outputs = atoi(words[4]), steps = atoi(words[5]), every = atoi(words[6]);
    uint32_t *names = calloc(outputs, sizeof *names);
    double *values = calloc(outputs, sizeof *values);
    for (int i = 0; i < outputs; i++) names[i] = first + i;
    unit = ((make *)dlsym(library, "fmi3InstantiateCoSimulation"))("u", words[2], "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    if (!unit) return 2;
    ((enter *)dlsym(library, "fmi3EnterInitializationMode"))(unit, 0, 0, 0, 0, 0);
    ((leave *)dlsym(library, "fmi3ExitInitializationMode"))(unit);
    do_step *step = (do_step *)dlsym(library, "fmi3DoStep");
    get *read = (get *)dlsym(library, "fmi3GetFloat64");
    for (int k = 1; k <= steps; k++) {
        if (step(unit, (k - 1) * STEP, STEP, 0, NULL, NULL, NULL, NULL)) return 3;
        if (k % every) continue;
        read(unit, names, outputs, values, outputs);
        for (int i = 0; i < outputs; i++) printf("%.17g%c", values[i], i + 1 < outputs ? ' ' : '\n');
    }
    return 0;
}
