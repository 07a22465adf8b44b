/* The binary interface of libaula.so.0: its types, and a definition of each function. abidiff
 * compares the library with it. Functions and members at the end of structs that begin with their
 * size may be added here; nothing may change. */
#include <stddef.h>
#include <stdint.h>

typedef struct aula_scene aula_scene;
typedef struct aula_room aula_room;
typedef uint64_t aula_source;

typedef struct aula_pose {
    float position[3];
    float yaw_rad;
    float pitch_rad;
    float roll_rad;
} aula_pose;

typedef struct aula_options {
    size_t size;
    const char *hrtf;
    double sample_rate_hz;
    double frame_rate_hz;
    double ir_length_s;
    int32_t clock;
    int32_t output;
    int32_t block;
    int32_t ambisonic_order;
    int32_t half_precision_tail;
    int32_t follow_paths;
    int32_t listeners;
    int32_t max_sources;
    int32_t rays;
    int32_t threads;
    uint64_t max_memory_bytes;
} aula_options;

typedef struct aula_signal {
    aula_source source;
    const float *samples;
} aula_signal;

typedef struct aula_status {
    size_t size;
    int64_t samples;
    uint64_t frames;
    uint64_t late_frames;
    double frame_ms;
    double frame_mean_ms;
    double frame_worst_ms;
    double frame_period_ms;
    double frame_age_s;
    double response_length_s;
    int64_t tail_samples;
    uint64_t memory_bytes;
    int32_t rays;
    int32_t channels;
    int32_t latency_samples;
    int32_t sources;
    uint64_t skipped_frames;
    int64_t muted_samples;
    uint64_t silent_pairs;
} aula_status;

const char *aula_version(void) { return 0; }

const char *aula_message(void) { return 0; }

int aula_scene_load(const char *file, aula_scene **scene) { return 0; }

int aula_scene_create(aula_scene **scene) { return 0; }

void aula_scene_destroy(aula_scene *scene) {}

int aula_scene_add_material(aula_scene *scene, const char *name, const float *absorption,
                            const float *scattering, const float *sound_reduction_db) {
    return 0;
}

int aula_scene_add_object(aula_scene *scene, const char *name, const float *vertices,
                          size_t vertex_count, const uint32_t *triangles, size_t triangle_count,
                          const char *material, int movable, size_t *object) {
    return 0;
}

int aula_scene_find_object(const aula_scene *scene, const char *name, size_t *object) { return 0; }

int aula_scene_make_movable(aula_scene *scene, size_t object) { return 0; }

int aula_scene_find_source(const aula_scene *scene, const char *name, aula_source *source) {
    return 0;
}

const char *aula_scene_source_name(const aula_scene *scene, aula_source source) { return 0; }

int aula_scene_add_source(aula_scene *scene, const char *name, const aula_pose *pose,
                          const char *directivity, float gain_db, aula_source *source) {
    return 0;
}

int aula_scene_set_listener(aula_scene *scene, const aula_pose *pose) { return 0; }

int aula_room_create(const aula_scene *scene, const aula_options *options, aula_room **room) {
    return 0;
}

void aula_room_destroy(aula_room *room) {}

int aula_room_set_scene(aula_room *room, const aula_scene *scene, int64_t at) { return 0; }

int aula_room_add_source(aula_room *room, const aula_pose *pose, const char *directivity,
                         int64_t at, aula_source *source) {
    return 0;
}

int aula_room_remove_source(aula_room *room, aula_source source, int64_t at) { return 0; }

int aula_room_set_source(aula_room *room, aula_source source, const aula_pose *pose, int64_t at) {
    return 0;
}

int aula_room_set_gain(aula_room *room, aula_source source, float gain_db, int64_t at) { return 0; }

int aula_room_set_listener(aula_room *room, int32_t listener, const aula_pose *pose, int64_t at) {
    return 0;
}

int aula_room_set_transform(aula_room *room, size_t object, const float *transform, int64_t at) {
    return 0;
}

int aula_room_set_material(aula_room *room, size_t object, const char *material, int64_t at) {
    return 0;
}

int aula_room_set_transform_by_name(aula_room *room, const char *object, const float *transform,
                                    int64_t at) {
    return 0;
}

int aula_room_set_material_by_name(aula_room *room, const char *object, const char *material,
                                   int64_t at) {
    return 0;
}

int aula_room_commit(aula_room *room, int64_t until) { return 0; }

int aula_room_process(aula_room *room, const aula_signal *inputs, size_t input_count,
                      float *const *outputs, size_t output_count, int32_t samples) {
    return 0;
}

int aula_room_process_exactly(aula_room *room, const aula_signal *inputs, size_t input_count,
                              float *const *outputs, size_t output_count, int32_t samples) {
    return 0;
}

int aula_room_status(const aula_room *room, aula_status *status) { return 0; }

int aula_room_is_silent(const aula_room *room, aula_source source, int32_t listener, int *silent) {
    return 0;
}

int aula_room_impulse_response(const aula_room *room, aula_source source, int32_t listener,
                               float *buffer, size_t capacity, size_t *length) {
    return 0;
}
