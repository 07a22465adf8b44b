/* Room acoustics in real time, for programs in C (C99 or later) and for bindings of other
 * languages.
 *
 * A scene is geometry, materials, sources and a listener. A room makes a scene audible block by
 * block: it computes how sound propagates on separate threads, and renders what each listener
 * hears. Neither needs an audio device.
 *
 *     aula_scene *scene;
 *     aula_room *room;
 *     aula_options options = {.size = sizeof(aula_options)};
 *     if (aula_scene_load("room.json", &scene) != AULA_OK ||
 *         aula_room_create(scene, &options, &room) != AULA_OK)
 *         return puts(aula_message());
 *
 * Axes: right-handed, in metres, x to the front, y to the left, z up. Angles in radians.
 * Bands: arrays of AULA_BANDS values have one for each octave, 63 Hz to 8 kHz.
 * Texts: UTF-8, ended by a zero; copied unless stated otherwise.
 *
 * Results: functions that return int return AULA_OK, AULA_FAILURE or AULA_INPUT_ERROR. A function
 * that does not return AULA_OK changes nothing, but clears its output parameters where stated, and
 * aula_message() describes the error. Errors are listed where they can occur, except these: a null
 * pointer is an AULA_INPUT_ERROR wherever it is not stated to be allowed, and lack of memory is an
 * AULA_FAILURE of every function that is not for the audio thread. A handle must not be used after
 * it was destroyed.
 *
 * Threads: the brackets at the end of each description name the threads that may call the function.
 * "Any thread" includes calls at the same time, but not the audio thread: such calls may lock, wait
 * and allocate.
 *
 * Times: a change of a room has a sample time `at`, which counts the rendered samples from 0 on.
 * With AULA_REAL_TIME it is ignored: changes take effect as early as possible. With AULA_EXACT a
 * change takes effect at its sample time (additions, removals, the orientation of heads) or in the
 * first propagation frame at or after it (all others). AULA_NOW, or a time that has passed, means
 * the next sample to render. */
#ifndef AULA_H
#define AULA_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(AULA_BUILDS_DLL)
#define AULA_API __declspec(dllexport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define AULA_API __attribute__((visibility("default")))
#else
#define AULA_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

enum {
    AULA_OK = 0,          /* done */
    AULA_FAILURE = 1,     /* a failure at run time: out of memory, no thread can be started */
    AULA_INPUT_ERROR = 2, /* an argument or a file cannot be used */

    AULA_BANDS = 8, /* octave bands */

    AULA_REAL_TIME = 0, /* clock: rendering never waits, the newest frame is heard */
    AULA_EXACT = 1,     /* clock: rendering waits; the same calls give the same samples */

    AULA_BINAURAL = 0, /* output: left and right ear */
    AULA_MONO = 1,     /* output: sound pressure */
    AULA_FOA = 2,      /* output: first-order ambisonics, AmbiX (W Y Z X), in head axes */
    AULA_TOA = 3       /* output: third-order ambisonics, AmbiX, 16 channels, in head axes */
};

/* Sample time of a change that takes effect as early as possible. */
#define AULA_NOW INT64_MIN

typedef struct aula_scene aula_scene; /* geometry, materials, sources, listener, settings */
typedef struct aula_room aula_room;   /* a scene that is made audible */
typedef uint64_t aula_source;         /* a source of a room; 0 is no source */

/* A position and an orientation. With all angles 0 its local axes are the world's. Usable are
 * coordinates from -1e6 to 1e6 m and finite angles; every other pose is an error. */
typedef struct aula_pose {
    float position[3]; /* m */
    float yaw_rad;     /* turn to the left */
    float pitch_rad;   /* elevation of the view direction, up is positive */
    float roll_rad;    /* turn about the view direction, positive lowers the right ear */
} aula_pose;

/* Settings of a room. A member that is 0 has its default, so that
 * `aula_options options = {.size = sizeof(aula_options)};` has all defaults. Versions to come may
 * add members at the end. */
typedef struct aula_options {
    size_t size;                 /* sizeof(aula_options) */
    const char *hrtf;            /* SOFA file for AULA_BINAURAL; null: MIT KEMAR */
    double sample_rate_hz;       /* 8000 to 384000; 0: 48000 */
    double frame_rate_hz;        /* propagation frames per second, up to 1000; 0: the scene's */
    double ir_length_s;          /* length of the responses, up to 10; 0: the scene's, or as long
                                    as the room sounds, at most 10 */
    int32_t clock;               /* AULA_REAL_TIME or AULA_EXACT */
    int32_t output;              /* AULA_BINAURAL, AULA_MONO, AULA_FOA or AULA_TOA, of each
                                    listener */
    int32_t block;               /* samples processed together in real time, best the size of most
                                    calls, 1 to 8192; 0: 256 */
    int32_t ambisonic_order;     /* of the reverberation in AULA_BINAURAL, 1 to 3; 0: 1 */
    int32_t half_precision_tail; /* not 0: late reverberation in half the memory, error -74 dB */
    int32_t follow_paths;        /* not 0: sources, listener 0 and objects follow the paths of the
                                    scene; changes of those with a path last for one frame */
    int32_t listeners;           /* number of listeners, up to 64; 0: 1 */
    int32_t max_sources;         /* most sources at the same time, up to 1024; 0: 16; at least the
                                    scene's. The memory grows with it */
    int32_t rays;                /* per source and frame, up to 200000; 0: the scene's, or
                                    with AULA_EXACT as its quality allows */
    int32_t threads;             /* that trace rays, up to 1024; 0: the scene's, or all processors
                                    but one */
    uint64_t max_memory_bytes;   /* a room whose renderers take more when it is created, some MB for
                                    each of max_sources at each listener, is refused; 0: 2^32 */
    const char *headphones;      /* sound file of an impulse response of at most 4 s with which the
                                    output of AULA_BINAURAL is convolved: 1 channel for both ears,
                                    or left and right; 1.0 is the gain 1; null: none */
} aula_options;

/* The input of a source in one call of aula_room_process() or aula_room_process_exactly(). */
typedef struct aula_signal {
    aula_source source;   /* signals of absent sources are ignored */
    const float *samples; /* as many as the call renders; null: silence. 1.0 of an omnidirectional
                             source has the amplitude 1.0 at a distance of 1 m in a free field */
} aula_signal;

/* State and load of a room. */
typedef struct aula_status {
    size_t size;              /* sizeof(aula_status), set by the caller */
    int64_t samples;          /* rendered samples: the sample time */
    uint64_t frames;          /* propagation frames computed */
    uint64_t late_frames;     /* frames that took longer than frame_period_ms */
    double frame_ms;          /* computation time of the newest frame */
    double frame_mean_ms;     /* mean computation time of all frames */
    double frame_worst_ms;    /* longest computation time of all frames */
    double frame_period_ms;   /* time between frames; in real time frame_ms must be below it */
    double frame_age_s;       /* time since the newest frame reached the sound (AULA_REAL_TIME) */
    double response_length_s; /* length of the impulse responses of the present scene;
                                 those that are heard are longer by that of the headphones */
    int64_t tail_samples;     /* how long sources are heard after their signals have ended */
    uint64_t memory_bytes;    /* memory of the propagation's caches */
    int32_t rays;             /* per source in the newest frame */
    int32_t channels;         /* outputs of all listeners, constant */
    int32_t latency_samples;  /* from inputs to outputs, constant: 0, for AULA_EXACT 256 */
    int32_t sources;          /* sources that are present */
    uint64_t skipped_frames;  /* frame times skipped because of late frames (AULA_REAL_TIME) */
    int64_t muted_samples;    /* samples of inputs and outputs that were not finite, or beyond 1e6
                                 in magnitude; they are silence */
    uint64_t silent_pairs;    /* pairs of a source and a listener at which nothing of the source
                                 has arrived for half a second: see aula_room_is_silent() */
} aula_status;

/* The version of the library, for instance "0.1.0". Constant. [any thread and the audio thread] */
AULA_API const char *aula_version(void);

/* The message of the last error on the calling thread, one line: what is wrong and what was
 * expected. Control characters in names are escaped, as in "a\x0ab". Empty if there was none. Valid
 * until the next error on this thread.
 * [any thread and the audio thread] */
AULA_API const char *aula_message(void);

/* Reads a scene file (JSON, docs/scene_format.md) with its meshes into a new scene. Sound files are
 * not read. `*scene` is null on errors: a file cannot be read, its content is wrong (the message
 * is that of the first error). [any thread] */
AULA_API int aula_scene_load(const char *file, aula_scene **scene);

/* Makes a new scene without geometry (a free field), without sources, with its listener at the
 * origin. `*scene` is null on errors. [any thread] */
AULA_API int aula_scene_create(aula_scene **scene);

/* Destroys a scene; null is allowed. Rooms keep what they need of it.
 * [any thread, no other call with this scene at the same time] */
AULA_API void aula_scene_destroy(aula_scene *scene);

/* Adds a material. It hides the one of this name that ships with Aula; add it before the objects
 * that use it. `absorption`: AULA_BANDS shares of the incident energy that are not reflected, 0 to
 * 1. `scattering`: AULA_BANDS shares of the reflected energy that leave diffusely, 0 to 1.
 * `sound_reduction_db`: AULA_BANDS values of the sound reduction index, 0 to 120 dB; null: opaque.
 * Errors: the name is empty or that of a material of the scene, a value is out of range, a band
 * transmits more than it absorbs. [any thread, no other call with this scene at the same time] */
AULA_API int aula_scene_add_material(aula_scene *scene, const char *name, const float *absorption,
                                     const float *scattering, const float *sound_reduction_db);

/* Adds an object, a mesh of triangles that reflect on both sides. `vertices`: 3 * `vertex_count`
 * coordinates, m, relative to the local origin, about which aula_room_set_transform() rotates.
 * `triangles`: 3 * `triangle_count` indices of vertices. `material`: a name of
 * aula_scene_add_material() or of a material that ships (`aula materials` lists them). `name`: for
 * aula_scene_find_object() and messages; null: none. `movable`: not 0 allows
 * aula_room_set_transform(). `object`: receives its index; may be null. Errors: no triangle, an
 * index out of range, a coordinate that is not finite or above 1e6 m, a name that exists, an
 * unknown material. [any thread, no other call with this scene at the same time] */
AULA_API int aula_scene_add_object(aula_scene *scene, const char *name, const float *vertices,
                                   size_t vertex_count, const uint32_t *triangles,
                                   size_t triangle_count, const char *material, int movable,
                                   size_t *object);

/* Finds an object by its name. `*object` receives its index. Error: there is none of this name.
 * [any thread] */
AULA_API int aula_scene_find_object(const aula_scene *scene, const char *name, size_t *object);

/* Allows aula_room_set_transform() for an object in rooms that are created later. Error: there is
 * no such object. [any thread, no other call with this scene at the same time] */
AULA_API int aula_scene_make_movable(aula_scene *scene, size_t object);

/* Finds a source of a scene file by its name. `*source` is its number in all rooms of this scene, 0
 * on errors. Error: there is none of this name. [any thread] */
AULA_API int aula_scene_find_source(const aula_scene *scene, const char *name, aula_source *source);

/* The name of a source of a scene by its number, 1, 2 and so on in the order of the file; null if
 * there is none. Valid until the scene changes. [any thread, no change of the scene at the same
 * time] */
AULA_API const char *aula_scene_source_name(const aula_scene *scene, aula_source source);

/* Adds a source that is present from the first sample on, with a gain in dB, at most 200, in rooms
 * that are created later. `name`: for aula_scene_find_source(). `directivity`: as for
 * aula_room_add_source(). `*source` receives its number in all rooms of this scene, 0 on errors:
 * the name is empty or that of a source of the scene, a pose or a gain that is not usable, an
 * unknown directivity. [any thread, no other call with this scene at the same time] */
AULA_API int aula_scene_add_source(aula_scene *scene, const char *name, const aula_pose *pose,
                                   const char *directivity, float gain_db, aula_source *source);

/* Moves and turns the listener of a scene, which all listeners of rooms that are created later have
 * at first. Error: the pose is not usable. [any thread, no other call with this scene at the same
 * time] */
AULA_API int aula_scene_set_listener(aula_scene *scene, const aula_pose *pose);

/* Makes a scene audible: copies it, starts the threads that compute the propagation, and prepares
 * all memory for rendering. The sources of the scene are present from the first sample on, and all
 * listeners have the pose of the scene's listener. Rooms are prepared, and their responses are as
 * long, as these sources and this listener need: a scene should have them where they are.
 * `options`: null for all defaults. Threads that the room starts have ordinary priority, whatever
 * the priority of the caller. `*room` is null on errors: an option out of range, a size that is
 * that of no aula_options, a member set that this version does not know, an HRTF that cannot be
 * read, more memory than max_memory_bytes (the message has the number of bytes), a thread that
 * cannot be started (AULA_FAILURE). [any thread] */
AULA_API int aula_room_create(const aula_scene *scene, const aula_options *options,
                              aula_room **room);

/* Destroys a room; null is allowed. Waits for the frame in progress, at most some 10 ms, and ends
 * the room's threads. [any thread, no other call with this room at the same time] */
AULA_API void aula_room_destroy(aula_room *room);

/* Exchanges the scene of a room while it plays: copies it, and returns when it is built; rendering
 * continues meanwhile. Sources and listeners stay with their poses and gains. The responses are as
 * long as those of `scene` need, which should be where the present ones are. Objects are those of
 * the scene at the time of a command, in real time those of `scene` after this call. The inputs
 * fade to the new scene over 50 ms, while the scene before rings out. Rays, threads, frame rate and
 * length of the responses are those of the options of aula_room_create(), if they give them. Takes
 * as long as aula_room_create(). Errors: wrong content of the scene, more memory than
 * max_memory_bytes, a failure of the propagation; the room then continues as before. [any thread,
 * not the one that renders] */
AULA_API int aula_room_set_scene(aula_room *room, const aula_scene *scene, int64_t at);

/* Adds a source at a pose. It fades in over 20 ms unless it begins at sample 0, and is heard from
 * its first frame on; in real time after at most two frames. `directivity`: the name of one that
 * ships ("omni", "subcardioid", "cardioid", "supercardioid", "figure_of_eight", "talker",
 * "loudspeaker"); null: "omni". `*source` receives its number, 0 on errors: more than max_sources,
 * a pose that is not usable, an unknown directivity, a failure of the propagation. [any thread] */
AULA_API int aula_room_add_source(aula_room *room, const aula_pose *pose, const char *directivity,
                                  int64_t at, aula_source *source);

/* Removes a source. Its input fades out over 20 ms, in which its signal should continue; its
 * reverberation decays naturally. Errors: the source is not present, a failure of the propagation.
 * [any thread] */
AULA_API int aula_room_remove_source(aula_room *room, aula_source source, int64_t at);

/* Moves and turns a source, without a click. Errors: the source is not present, the pose is not
 * usable, a failure of the propagation. [any thread] */
AULA_API int aula_room_set_source(aula_room *room, aula_source source, const aula_pose *pose,
                                  int64_t at);

/* Sets the gain of a source in dB, at most 200; -INFINITY mutes it. Errors: the source is not
 * present, the gain is out of range or not a number, a failure of the propagation. [any thread] */
AULA_API int aula_room_set_gain(aula_room *room, aula_source source, float gain_db, int64_t at);

/* Moves and turns the head of a listener, 0 to listeners - 1. Errors: there is no such listener,
 * the pose is not usable, a failure of the propagation. [any thread] */
AULA_API int aula_room_set_listener(aula_room *room, int32_t listener, const aula_pose *pose,
                                    int64_t at);

/* Moves a movable object. `transform`: three rows of four numbers, each a row of the rotation
 * matrix and a component of the translation in m. The rotation is about the object's local origin;
 * the transform replaces the earlier one. Errors: there is no such object, it is not movable, the
 * transform is not rigid and finite, a failure of the propagation. [any thread] */
AULA_API int aula_room_set_transform(aula_room *room, size_t object, const float *transform,
                                     int64_t at);

/* The same for an object by its name, the first one in the scene at the time of the command: right
 * also while another thread calls aula_room_set_scene(), when an index may be that of another
 * object. [any thread] */
AULA_API int aula_room_set_transform_by_name(aula_room *room, const char *object,
                                             const float *transform, int64_t at);

/* Gives all triangles of an object a material of the scene or one that ships, by its name. The
 * length of the responses remains. Errors: there is no such object or material, a failure of the
 * propagation. [any thread] */
AULA_API int aula_room_set_material(aula_room *room, size_t object, const char *material,
                                    int64_t at);

/* The same for an object by its name. [any thread] */
AULA_API int aula_room_set_material_by_name(aula_room *room, const char *object,
                                            const char *material, int64_t at);

/* Declares that all changes before the sample time `until` have been made. With AULA_EXACT the
 * frames before it are then computed while earlier samples are rendered; without this call a frame
 * is computed when rendering reaches it. No effect with AULA_REAL_TIME. Error: a failure of the
 * propagation. [any thread] */
AULA_API int aula_room_commit(aula_room *room, int64_t until);

/* Renders any number of samples of an AULA_REAL_TIME room; wait-free. `inputs`: `input_count`
 * signals, at most max_sources; null if there is none. Of several signals of one source the first
 * counts; a source without a signal is silent. `outputs`: as many pointers as the room has
 * channels, to `samples` samples each, which are overwritten: all channels of listener 0, then
 * those of listener 1, and so on. Outputs are not limited: sources near a head exceed 1. Samples of
 * inputs and outputs that are not finite, or beyond 1e6 in magnitude, are silence (muted_samples of
 * aula_status). Errors: another number of outputs, too many inputs, a negative number of samples,
 * an AULA_EXACT room; the outputs are then unchanged. If the propagation has failed, the last frame
 * is still heard, and aula_room_status() returns the error. [one audio thread] */
AULA_API int aula_room_process(aula_room *room, const aula_signal *inputs, size_t input_count,
                               float *const *outputs, size_t output_count, int32_t samples);

/* The same for an AULA_EXACT room: waits for the frames of the samples that it renders. The same
 * changes and signals give the same samples for any sequence of block sizes and any number of
 * threads. Outputs lag the inputs by latency_samples. Further errors: an AULA_REAL_TIME room, a
 * failure of the propagation. [any single thread but the audio thread] */
AULA_API int aula_room_process_exactly(aula_room *room, const aula_signal *inputs,
                                       size_t input_count, float *const *outputs,
                                       size_t output_count, int32_t samples);

/* Writes the present state. Errors: a size that is that of no aula_status, a failure of the
 * propagation. After such a failure every function that changes the room returns the same error.
 * [any thread] */
AULA_API int aula_room_status(const aula_room *room, aula_status *status);

/* Whether nothing of a source has reached a listener in the frames of half a second, whatever its
 * signal and gain: one of the two may be outside of the room, inside of an object, or behind walls
 * that transmit nothing. `*silent`: 1 or 0, 0 on errors: the source is not present, there is no
 * such listener, a failure of the propagation. [any thread] */
AULA_API int aula_room_is_silent(const aula_room *room, aula_source source, int32_t listener,
                                 int *silent);

/* Copies the impulse response of a source at a listener in the newest frame, with its gain and the
 * orientation of the head. `buffer`: [channel][capacity] samples of the listener's channels; sample
 * 0 is the emission. Of each channel at most `capacity` samples are written, and zeros after the
 * end; null is allowed if `capacity` is 0. `*length`: the length of the response, 0 before the
 * first frame of the source. Waits for the frame in progress. Errors: the source is not present,
 * there is no such listener, a failure of the propagation. [any thread] */
AULA_API int aula_room_impulse_response(const aula_room *room, aula_source source, int32_t listener,
                                        float *buffer, size_t capacity, size_t *length);

#ifdef __cplusplus
}
#endif

#endif /* AULA_H */
