/* Around the compiled kernels: reads a contact, passes addresses, copies results.
 *
 * contact_kernels.h has the kernels' own records as structs, the numbers of the arrays of a workspace, the texts of
 * the status bits. */
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime.h"
#include "contact_kernels.h"
#define WRSIM_API EXPORT
#include "wrsim_contact.h"

#define LARGEST 1e9  /* of an argument: products of thirty of them are finite */
#define ROUGH 1e-6   /* of the axle's length: ten times the round-off of single precision */
#define SEARCH_DOUBLES ((int64_t)((sizeof(struct search) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT / 8))

struct wrsim_contact {
    double *buffer;
    int64_t doubles;
    int64_t rows[1 + ARRAYS][4]; /* offset and sizes of the search for a load and of every array, see wrsim.jit.arena */
    int evaluated;
    char *description;
};

/* The head of a file; behind it description, index, buffer, and the checksum of all before (8 bytes). */
struct head {
    char magic[8];
    int64_t version;
    char kernels[16];
    int64_t arrays, doubles, letters;
};

static const struct {
    int status;
    const char *text;
} words[] = {
    STATUS_WORDS,
    {WRSIM_NO_FILE, "the file cannot be read"},
    {WRSIM_OTHER_FILE, "the file is not one of ContactModel.save_for_library"},
    {WRSIM_OTHER_KERNELS, "the file was written by another version of wrsim than this library"},
    {WRSIM_DAMAGED, "the file is damaged"},
    {WRSIM_NO_MEMORY, "there is not enough memory"},
    {WRSIM_ARGUMENT, "an argument is a null pointer or out of range"},
    {WRSIM_FAILED, "a kernel ended early"},
    {WRSIM_NOT_FINITE, "the forces are not numbers: the pose, or the turn of the rail, is out of all proportion"},
};

static const int64_t *row(const wrsim_contact *c, int number) { return c->rows[1 + number]; }

static void *array(const wrsim_contact *c, int number) { return c->buffer + row(c, number)[0]; }

static struct call *call_of(const wrsim_contact *c) { return array(c, ARRAY_CALL); }

static const struct total *total_of(const wrsim_contact *c) { return array(c, ARRAY_TOTAL); }

/* Whether these are numbers up to LARGEST. */
static int small(const double *numbers, int count)
{
    for (int i = 0; i < count; i++)
        if (!(fabs(numbers[i]) <= LARGEST)) return 0;
    return 1;
}

static int finite(const double *numbers, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(numbers[i])) return 0;
    return 1;
}

/* CRC-32 as in zlib. */
static uint32_t checksum(const unsigned char *bytes, size_t size)
{
    uint32_t table[256], crc = 0xffffffffu;
    for (uint32_t i = 0; i < 256; i++) {
        table[i] = i;
        for (int bit = 0; bit < 8; bit++) table[i] = table[i] & 1 ? table[i] >> 1 ^ 0xedb88320u : table[i] >> 1;
    }
    for (size_t i = 0; i < size; i++) crc = crc >> 8 ^ table[(crc ^ bytes[i]) & 255];
    return ~crc;
}

/* The whole file in new memory; NULL and a status where that fails. */
static unsigned char *read_file(const char *path, size_t *size, int *status)
{
    unsigned char *bytes = NULL;
    *status = WRSIM_NO_FILE;
#ifdef __wasm__
    (void)path, (void)size;
    errno = ENOSYS;
#else
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    if (fseek(file, 0, SEEK_END) == 0) {
        long end = ftell(file);
        if (end >= 0 && end < LONG_MAX && fseek(file, 0, SEEK_SET) == 0) {
            *size = (size_t)end;
            bytes = malloc(*size + 1);
            if (!bytes) *status = WRSIM_NO_MEMORY;
            if (bytes && fread(bytes, 1, *size, file) != *size) {
                free(bytes);
                bytes = NULL;
            }
        }
    }
    fclose(file);
#endif
    return bytes;
}

/* Whether the arrays lie one behind the other within the buffer, and hold what is written here. */
static int fits(const int64_t index[ARRAYS][4], int64_t doubles)
{
    static const int64_t rows[][2] = {{ARRAY_CALL, sizeof(struct call)},   {ARRAY_STATE, sizeof(struct state)},
                                      {ARRAY_TOTAL, sizeof(struct total)}, {ARRAY_MEMO, sizeof(struct memo)},
                                      {ARRAY_POSE, 12 * 8}};
    const int64_t *patches = index[ARRAY_PATCHES], *strips = index[ARRAY_STRIPS], step = ALIGNMENT / 8;
    int64_t end = 0, sizes[ARRAYS];
    for (int i = 0; i < ARRAYS; i++) {
        const int64_t *of = index[i];
        const int64_t across = i == ARRAY_SHAPE || i == ARRAY_POSE ? 1 : of[2], deep = of[3] ? of[3] : 1;
        if (of[1] < 0 || across < 0 || deep < 0 || of[1] > doubles || across > doubles || deep > doubles) return 0;
        if (across && deep > doubles / across) return 0;
        sizes[i] = across * deep;
        if (sizes[i] && of[1] > doubles / sizes[i]) return 0;
        sizes[i] *= of[1];
        if (of[0] != end && !(sizes[i] == 0 && of[0] >= 0 && of[0] < end)) return 0;
        end += (sizes[i] + step - 1) / step * step;
        if (end > doubles) return 0;
    }
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (sizes[rows[i][0]] * 8 < rows[i][1]) return 0;
    return end == doubles && patches[2] * 8 == sizeof(struct lobe) && strips[1] >= patches[1] &&
           strips[3] * 8 == sizeof(struct strip);
}

/* Whether these bytes are a whole contact for these kernels. */
static int check(const unsigned char *bytes, size_t size, struct head *head)
{
    uint64_t sum, rest = size;
    int64_t index[ARRAYS][4];
    if (size < sizeof *head || memcmp(bytes, FILE_MAGIC, sizeof head->magic) != 0) return WRSIM_OTHER_FILE;
    memcpy(head, bytes, sizeof *head);
    if (head->version != FILE_VERSION || memcmp(head->kernels, KERNELS, sizeof head->kernels) != 0)
        return WRSIM_OTHER_KERNELS;
    rest -= sizeof *head;
    if (rest < sizeof sum + ARRAYS * 4 * 8 || head->arrays != ARRAYS) return WRSIM_DAMAGED;
    rest -= sizeof sum + ARRAYS * 4 * 8;
    if (head->letters < 0 || (uint64_t)head->letters > rest) return WRSIM_DAMAGED;
    rest -= (uint64_t)head->letters;
    if (rest % 8 != 0 || head->doubles < 0 || (uint64_t)head->doubles != rest / 8) return WRSIM_DAMAGED;
    memcpy(&sum, bytes + size - sizeof sum, sizeof sum);
    if (checksum(bytes, size - sizeof sum) != sum) return WRSIM_DAMAGED;
    memcpy(index, bytes + sizeof *head + head->letters, sizeof index);
    return fits(index, head->doubles) ? 0 : WRSIM_DAMAGED;
}

/* A contact from bytes that are checked; NULL where memory is short. */
static wrsim_contact *unpack(const unsigned char *bytes, const struct head *head)
{
    wrsim_contact *c = calloc(1, sizeof *c);
    const int64_t search[4] = {head->doubles, 1, sizeof(struct search) / 8, 0};
    size_t room = (size_t)head->doubles * 8;
    if (!c) return NULL;
    c->doubles = head->doubles + SEARCH_DOUBLES;
    c->description = calloc(1, (size_t)head->letters + 1);
    c->buffer = take((size_t)c->doubles * 8);
    if (!c->description || !c->buffer) {
        wrsim_contact_free(c);
        return NULL;
    }
    bytes += sizeof *head;
    memcpy(c->description, bytes, (size_t)head->letters);
    bytes += head->letters;
    memcpy(c->rows[0], search, sizeof search);
    memcpy(c->rows[1], bytes, sizeof c->rows - sizeof search);
    memcpy(c->buffer, bytes + sizeof c->rows - sizeof search, room);
    return c;
}

/* Put the reason for a status into the message; returns the status. */
static int report(int status, const char *path, char *message, size_t size)
{
    char text[160];
    if (!message || size == 0) return status;
    message[0] = 0;
    if (status == 0) return status;
    wrsim_contact_words(status, text, sizeof text);
    snprintf(message, size, "%s: %s%s%s", path ? path : "(no path)", text, status == WRSIM_NO_FILE ? ": " : "",
             status == WRSIM_NO_FILE ? strerror(errno) : status == WRSIM_OTHER_KERNELS ? " (kernels " KERNELS ")" : "");
    return status;
}

const char *wrsim_contact_version(void)
{
    return "wrsim " WRSIM_VERSION ", kernels " KERNELS ", processors " TARGET;
}

/* Open bytes; name: where they are from. */
static int open_bytes(const void *bytes, size_t length, const char *name, wrsim_contact **contact, char *message,
                      size_t size)
{
    struct head head;
    int status = check(bytes, length, &head);
    if (status == 0) {
        *contact = unpack(bytes, &head);
        if (!*contact) status = WRSIM_NO_MEMORY;
    }
    return report(status, name, message, size);
}

int wrsim_contact_open(const char *path, wrsim_contact **contact, char *message, size_t size)
{
    size_t length = 0;
    int status;
    unsigned char *bytes;
    errno = 0;
    if (contact) *contact = NULL;
    if (!path || !contact) return report(WRSIM_ARGUMENT, path, message, size);
    bytes = read_file(path, &length, &status);
    if (!bytes) return report(status, path, message, size);
    status = open_bytes(bytes, length, path, contact, message, size);
    free(bytes);
    return status;
}

int wrsim_contact_open_memory(const void *bytes, size_t length, wrsim_contact **contact, char *message, size_t size)
{
    if (contact) *contact = NULL;
    if (!bytes || !contact) return report(WRSIM_ARGUMENT, NULL, message, size);
    return open_bytes(bytes, length, "(memory)", contact, message, size);
}

void wrsim_contact_free(wrsim_contact *contact)
{
    if (!contact) return;
    free(contact->description);
    give(contact->buffer);
    free(contact);
}

const char *wrsim_contact_description(const wrsim_contact *contact) { return contact ? contact->description : ""; }

int wrsim_contact_follow(wrsim_contact *contact, int on)
{
    if (!contact) return WRSIM_ARGUMENT;
    ((struct state *)array(contact, ARRAY_STATE))->start = on ? FROM_LAST : COLD_START;
    ((struct memo *)array(contact, ARRAY_MEMO))->grids_before = 0;
    return 0;
}

int wrsim_contact_turn_rail(wrsim_contact *contact, double twist, double outward, double up)
{
    const double turning[] = {twist, outward, up};
    if (!contact || !small(turning, 3)) return WRSIM_ARGUMENT;
    call_of(contact)->twist = twist;
    call_of(contact)->bow_o = outward;
    call_of(contact)->bow_b = up;
    return 0;
}

int wrsim_contact_turn_wheel(wrsim_contact *contact, double angle)
{
    if (!contact || !isfinite(angle)) return WRSIM_ARGUMENT;
    call_of(contact)->wheel_angle = angle;
    return 0;
}

int wrsim_contact_set_friction(wrsim_contact *contact, double coefficient)
{
    if (!contact || !(coefficient >= 0.0 && coefficient <= MOST_FRICTION) || row(contact, ARRAY_FRICTION)[1] > 0)
        return WRSIM_ARGUMENT;
    call_of(contact)->mu = call_of(contact)->mu_gauge = coefficient;
    return 0;
}

/* Set a pose, which is checked. */
static int place_wheel(wrsim_contact *contact, const double origin[3], const double axle[3], const double velocity[3],
                       const double omega[3], double place)
{
    const double *parts[] = {origin, axle, velocity, omega};
    double *pose;
    if (!contact || !origin || !axle || !velocity || !omega || !small(&place, 1)) return WRSIM_ARGUMENT;
    for (int i = 0; i < 4; i++)
        if (!small(parts[i], 3)) return WRSIM_ARGUMENT;
    if (fabs(sqrt(axle[0] * axle[0] + axle[1] * axle[1] + axle[2] * axle[2]) - 1.0) > ROUGH ||
        axle[0] * axle[0] >= 1.0)
        return WRSIM_ARGUMENT;
    pose = array(contact, ARRAY_POSE);
    for (int i = 0; i < 12; i++) pose[i] = parts[i / 3][i % 3];
    call_of(contact)->place = place;
    return 0;
}

/* Run a stage on the rows from this one on; a status. */
static int compute(wrsim_contact *contact, int kernel, int first)
{
    int64_t status;
    contact->evaluated = 0;
    status = run(kernel, contact->buffer, contact->doubles, contact->rows[first], 1 + ARRAYS - first, WRSIM_FAILED);
    if (status == WRSIM_FAILED) return WRSIM_FAILED;
    if (!finite(&total_of(contact)->Ft, 3) || !finite(&total_of(contact)->Mt, 3)) return WRSIM_NOT_FINITE;
    contact->evaluated = 1;
    return (int)status;
}

int wrsim_contact_evaluate(wrsim_contact *contact, const double origin[3], const double axle[3],
                           const double velocity[3], const double omega[3], double place)
{
    int status = place_wheel(contact, origin, axle, velocity, omega, place);
    return status ? status : compute(contact, CONTACT_STAGE, 1);
}

int wrsim_contact_solve(wrsim_contact *contact, double load, double origin[3], const double axle[3],
                        const double velocity[3], const double omega[3], double place)
{
    struct search *search;
    const struct model *model;
    int status = place_wheel(contact, origin, axle, velocity, omega, place);
    if (status == 0 && !(load > 0.0 && load <= LARGEST)) status = WRSIM_ARGUMENT;
    if (status) return status;
    search = (struct search *)(contact->buffer + contact->rows[0][0]);
    model = array(contact, ARRAY_MODEL);
    *search = (struct search){.load = load, .tolerance = LOAD_TOLERANCE, .farthest = FARTHEST, .start = origin[2]};
    search->scale = fmax(cbrt(9.0 * load * load / (16.0 * model->E * model->E * model->radius)), LEAST_SCALE);
    status = compute(contact, LOAD_STAGE, 0);
    origin[2] = ((const double *)array(contact, ARRAY_POSE))[2];
    return status;
}

int wrsim_contact_forces(const wrsim_contact *contact, wrsim_contact_result *result)
{
    const struct total *total;
    if (!contact || !result || !contact->evaluated) return WRSIM_ARGUMENT;
    total = total_of(contact);
    memcpy(result->force, (double[]){total->Ft, total->Fo, total->Fb}, sizeof result->force);
    memcpy(result->moment, (double[]){total->Mt, total->Mo, total->Mb}, sizeof result->moment);
    result->wear_number = total->wear;
    result->closest = total->closest;
    result->patches = (int32_t)total->lobes;
    result->status = (int32_t)total->status;
    return 0;
}

int wrsim_contact_patches(const wrsim_contact *contact, wrsim_contact_patch *patches, int most)
{
    int count;
    if (!contact || !contact->evaluated || most < 0 || (most > 0 && !patches)) return WRSIM_ARGUMENT;
    count = (int)total_of(contact)->lobes;
    for (int i = 0; i < count && i < most; i++) {
        const struct lobe *of = (const struct lobe *)array(contact, ARRAY_PATCHES) + i;
        patches[i] = (wrsim_contact_patch){PATCH_VALUES(of)};
    }
    return count;
}

int wrsim_contact_strips(const wrsim_contact *contact, int patch, wrsim_contact_strip *strips, int most)
{
    const struct lobe *lobe;
    const struct strip *first;
    int count;
    if (!contact || !contact->evaluated || most < 0 || (most > 0 && !strips)) return WRSIM_ARGUMENT;
    if (patch < 0 || patch >= total_of(contact)->lobes) return WRSIM_ARGUMENT;
    lobe = (const struct lobe *)array(contact, ARRAY_PATCHES) + patch;
    first = (const struct strip *)array(contact, ARRAY_STRIPS) + patch * row(contact, ARRAY_STRIPS)[2];
    count = (int)lobe->n_strips;
    for (int i = 0; i < count && i < most; i++) {
        const struct strip *of = first + i;
        strips[i] = (wrsim_contact_strip){STRIP_VALUES(of)};
    }
    return count;
}

int wrsim_contact_tractions(const wrsim_contact *contact, int patch, double *shares, int most)
{
    const struct lobe *lobe;
    const double *first;
    int64_t rows, across, cells;
    if (!contact || !contact->evaluated || most < 0 || (most > 0 && !shares)) return WRSIM_ARGUMENT;
    if (patch < 0 || patch >= total_of(contact)->lobes) return WRSIM_ARGUMENT;
    lobe = (const struct lobe *)array(contact, ARRAY_PATCHES) + patch;
    rows = row(contact, ARRAY_WORK)[1], across = row(contact, ARRAY_WORK)[2], cells = row(contact, ARRAY_SHAPE)[1];
    if (rows < SCRATCH + row(contact, ARRAY_PATCHES)[1] * cells) return 0;
    first = (const double *)array(contact, ARRAY_WORK) + (SCRATCH + patch * cells) * across;
    for (int64_t i = 0; i < lobe->n_strips * cells && i < most; i++)
        shares[i] = first[i % cells * across + i / cells];
    return (int)(lobe->n_strips * cells);
}

int wrsim_contact_words(int status, char *text, size_t size)
{
    size_t length = 0;
    if (text && size > 0) text[0] = 0;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        const char *one = words[i].text, *join = length ? "; " : "";
        if (status < 0 ? words[i].status != status : words[i].status < 0 || !(words[i].status & status)) continue;
        if (text && length < size) snprintf(text + length, size - length, "%s%s", join, one);
        length += strlen(join) + strlen(one);
    }
    return (int)length;
}
