/* Contacts at many poses through the library, on threads that each open the file for themselves.
 *
 *     library_poses CONTACT POSES RESULTS FOLLOW THREADS
 *
 * POSES: rows of 13 doubles, the pose and the place. RESULTS: of every pose its result, patches and strips as they lie
 * in memory. Ends with 0 if all threads have the same bytes. THREADS 0: without threads. */
#ifndef _WIN32
#include <pthread.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "wrsim_contact.h"

#define MOST_PATCHES 6
#define MOST_STRIPS 2000

struct work {
    const char *file;
    const double *poses;
    long count;
    int follow, failed;
    char *out;
    size_t size, room;
};

static void add(struct work *w, const void *bytes, size_t size)
{
    if (w->size + size > w->room) {
        w->room = 2 * (w->size + size);
        w->out = realloc(w->out, w->room);
        if (!w->out) abort();
    }
    memcpy(w->out + w->size, bytes, size);
    w->size += size;
}

static void *compute(void *given)
{
    struct work *w = given;
    wrsim_contact *contact;
    char message[400];
    static _Thread_local wrsim_contact_patch patches[MOST_PATCHES];
    static _Thread_local wrsim_contact_strip strips[MOST_STRIPS];
    if (wrsim_contact_open(w->file, &contact, message, sizeof message) != 0) {
        fprintf(stderr, "%s\n", message);
        w->failed = 1;
        return NULL;
    }
    wrsim_contact_follow(contact, w->follow);
    for (long i = 0; i < w->count; i++) {
        const double *p = w->poses + 13 * i;
        wrsim_contact_result result = {.status = -99};
        int status = wrsim_contact_evaluate(contact, p, p + 3, p + 6, p + 9, p[12]);
        if (status < 0 || wrsim_contact_forces(contact, &result) != 0 || result.status != status) w->failed = 1;
        add(w, &result, sizeof result);
        int n = wrsim_contact_patches(contact, patches, MOST_PATCHES);
        for (int j = 0; j < n; j++) {
            int m = wrsim_contact_strips(contact, j, strips, MOST_STRIPS);
            if (m != patches[j].strips) w->failed = 1;
            add(w, &patches[j], sizeof *patches);
            add(w, strips, (size_t)m * sizeof *strips);
        }
    }
    wrsim_contact_free(contact);
    return NULL;
}

int main(int count, char **words)
{
    if (count != 6) return 2;
    int threads = atoi(words[5]), bad = 0;
    FILE *in = fopen(words[2], "rb"), *out = fopen(words[3], "wb");
    if (!in || !out || threads < 0) return 2;
    fseek(in, 0, SEEK_END);
    long size = ftell(in);
    rewind(in);
    double *poses = malloc((size_t)size);
    if (!poses || fread(poses, 1, (size_t)size, in) != (size_t)size) return 2;
    struct work *work = calloc((size_t)threads + 1, sizeof *work);
    for (int t = 0; t <= threads; t++)
        work[t] = (struct work){words[1], poses, size / 8 / 13, atoi(words[4]), 0, NULL, 0, 0};
    if (threads == 0) {
        compute(&work[0]);
        bad = work[0].failed;
    }
#ifndef _WIN32
    pthread_t *running = calloc((size_t)threads, sizeof *running);
    for (int t = 0; t < threads; t++) pthread_create(&running[t], NULL, compute, &work[t]);
    for (int t = 0; t < threads; t++) pthread_join(running[t], NULL);
#endif
    for (int t = 0; t < threads; t++) {
        bad |= work[t].failed || work[t].size != work[0].size || memcmp(work[t].out, work[0].out, work[0].size) != 0;
    }
    fwrite(work[0].out, 1, work[0].size, out);
    return fclose(out) != 0 || bad;
}
