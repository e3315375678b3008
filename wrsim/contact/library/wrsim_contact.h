/* The contact of one wheel on one rail, compiled: no Python runs behind it. Manual: docs/user/library.md.
 *
 * Units are SI and radians. Vectors have their components in the axes of the rail: along the track, outward (to the
 * field side), up; the origin is the rail's profile origin beside the wheel. On the right side these axes are
 * left-handed: give the components of the angular velocity along the track and up with the opposite sign, and take
 * those of the moment so.
 *
 * A status is 0 (all is well), a sum of bits above 0 (a contact with remarks: wrsim_contact_words has their text), or
 * below 0 (a call without a result). A contact belongs to one thread at a time; different contacts share nothing. */
#ifndef WRSIM_CONTACT_H
#define WRSIM_CONTACT_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define WRSIM_API __attribute__((visibility("default")))
#else
#define WRSIM_API
#endif

/* Status of a call that did nothing. */
enum {
    WRSIM_NO_FILE = -1,      /* the file cannot be read */
    WRSIM_OTHER_FILE = -2,   /* it is no contact */
    WRSIM_OTHER_KERNELS = -3, /* it was written by another version of wrsim */
    WRSIM_DAMAGED = -4,      /* it ends too early, its checksum is wrong, or its arrays do not fit */
    WRSIM_NO_MEMORY = -5,
    WRSIM_PROCESSOR = -6,    /* the processor lacks instructions that the library uses */
    WRSIM_ARGUMENT = -7,     /* a null pointer, numbers beyond 1e9 or not finite, an axle that is no unit vector */
    WRSIM_FAILED = -8,       /* a kernel ended early */
    WRSIM_NOT_FINITE = -9    /* the forces are not numbers */
};

/* A wheel profile on a rail profile, with all settings and the memory to compute in. */
typedef struct wrsim_contact wrsim_contact;

/* All forces on the wheel. */
typedef struct {
    double force[3];         /* [N] */
    double moment[3];        /* about the wheel's profile origin [N m] */
    double wear_number;      /* T-gamma: what creep dissipates over the distance [N] */
    double closest;          /* smallest distance between the profiles, negative in contact [m] */
    int32_t patches;         /* rows that wrsim_contact_patches has */
    int32_t status;          /* of the evaluation */
} wrsim_contact_result;

/* A patch, or a lobe of one: rows with the same group share a patch, and their forces and areas add up. */
typedef struct {
    double N, Fx, Fy, Mz;    /* normal force, creep forces on the wheel [N], spin moment [N m] */
    double p0, area;         /* largest pressure [Pa], area [m2] */
    double length, width;    /* along the track and across [m] */
    double approach;         /* [m] */
    double angle;            /* contact angle at the main point [rad] */
    double angle_min, angle_max;
    double xi, eta, phi;     /* creepages [1] and spin [1/m] at the main point */
    double wear;             /* its part of the wear number [N] */
    double x, o, b;          /* main point: along the track, outward, up [m] */
    double no, nb;           /* normal from rail to wheel there: outward, up */
    double arc_wheel, arc_rail; /* arclengths of the main point on both profiles [m] */
    int32_t group;           /* number of the patch */
    int32_t strips;          /* rows that wrsim_contact_strips has */
} wrsim_contact_patch;

/* A strip along the track. */
typedef struct {
    double s, ds;            /* centre and width, by the rail's arclength from the main point [m] */
    double x, a;             /* middle along the track and half length [m] */
    double p;                /* largest pressure [Pa] */
    double o, b;             /* centre: outward, up [m] */
    double no, nb;           /* normal from rail to wheel: outward, up */
    double N, Fx, Fy, Mz;    /* forces on the wheel [N], moment about the centre [N m] */
    double xi, eta, phi;     /* creepages [1], spin [1/m] */
    double mu;               /* coefficient of friction */
    double penetration;      /* [m] */
} wrsim_contact_strip;

/* Version of wrsim, of its kernels, and the processors that they are compiled for. */
WRSIM_API const char *wrsim_contact_version(void);

/* Read a file of ContactModel.save_for_library. *contact: NULL unless the status is 0. message: NULL, or where the
 * reason goes, at most `size` bytes with the zero at its end. Free the contact with wrsim_contact_free. */
WRSIM_API int wrsim_contact_open(const char *path, wrsim_contact **contact, char *message, size_t size);

/* Give the memory back; NULL is allowed. */
WRSIM_API void wrsim_contact_free(wrsim_contact *contact);

/* What the file holds: profiles, radius, models. */
WRSIM_API const char *wrsim_contact_description(const wrsim_contact *contact);

/* Strip model: 1 starts each evaluation from the last one (in runs: faster, equal to its tolerance), 0 starts cold each
 * time, so that a pose has the same bits whatever came first. 0 after opening. Other models do not care. */
WRSIM_API int wrsim_contact_follow(wrsim_contact *contact, int on);

/* How the rail turns along the track, positive where its outer side rises [rad/m], and how it bends outward and up
 * [1/m], from now on. All 0 after opening. */
WRSIM_API int wrsim_contact_turn_rail(wrsim_contact *contact, double twist, double outward, double up);

/* Angle by which a wheel out of round has rolled [rad], from now on. 0 after opening. */
WRSIM_API int wrsim_contact_turn_wheel(wrsim_contact *contact, double angle);

/* Contact at a pose. origin: of the wheel's profile on the axle [m]; axle: its direction, outward, of length 1;
 * velocity: of that origin [m/s]; omega: angular velocity of the wheel [rad/s]; place: distance along a rail whose
 * profile or friction changes along the track [m]. Returns the status. */
WRSIM_API int wrsim_contact_evaluate(wrsim_contact *contact, const double origin[3], const double axle[3],
                                     const double velocity[3], const double omega[3], double place);

/* Of the last evaluation: forces; up to `most` patches, returns how many there are; up to `most` strips of a patch,
 * returns how many there are. Below 0: a status. */
WRSIM_API int wrsim_contact_forces(const wrsim_contact *contact, wrsim_contact_result *result);
WRSIM_API int wrsim_contact_patches(const wrsim_contact *contact, wrsim_contact_patch *patches, int most);
WRSIM_API int wrsim_contact_strips(const wrsim_contact *contact, int patch, wrsim_contact_strip *strips, int most);

/* The text of a status, empty where all is well, at most `size` bytes with the zero at its end. Returns its length. */
WRSIM_API int wrsim_contact_words(int status, char *text, size_t size);

#ifdef __cplusplus
}
#endif
#endif
