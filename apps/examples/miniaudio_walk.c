/* A room in a program with miniaudio, in C99: a sound comes from the first source of a scene, and
 * the listener walks a circle with a radius of 0.5 m about a place, for 6 s:
 *
 *     miniaudio_walk SCENE SOUND X Y Z
 *     miniaudio_walk scenes/shoebox.json scenes/sounds/castanets.wav 6 5 1.7
 *
 * cc -std=c99 miniaudio_walk.c $(pkg-config --cflags --libs aula) -lm -lpthread -ldl \
 *     -o miniaudio_walk */
#define _POSIX_C_SOURCE 200112L /* nanosleep */
#define MINIAUDIO_IMPLEMENTATION
#include <aula.h>
#include <math.h>
#include <miniaudio.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { RATE_HZ = 48000, SECONDS = 6, POSES_HZ = 60, BLOCK = 256 /* the default of aula_options */ };

typedef struct {
    aula_room *room;
    float *sound;
    ma_uint64 length, at; /* samples of the sound, the next one */
    float peak;           /* of what has been played */
} player;

static void stop_on(int failed, const char *message) {
    if (!failed) return;
    fprintf(stderr, "miniaudio_walk: %s\n", message);
    exit(failed);
}

static void require(int result) { stop_on(result, aula_message()); }

static void require_ma(ma_result result, int failed, const char *what) {
    if (result == MA_SUCCESS) return;
    fprintf(stderr, "miniaudio_walk: %s: %s\n", what, ma_result_description(result));
    exit(failed);
}

/* One circle in 6 s, looking along it. */
static aula_pose walk(const float *centre, double time_s) {
    const float angle = (float)(time_s * 2 * 3.14159265 / SECONDS);
    aula_pose pose = {{centre[0], centre[1], centre[2]}, angle + 1.5707963F, 0, 0};
    pose.position[0] += 0.5F * cosf(angle);
    pose.position[1] += 0.5F * sinf(angle);
    return pose;
}

/* Renders left, right, left, ... [audio thread] No allocation, no lock, no wait. */
static void render(player *p, float *pairs, int count) {
    float input[BLOCK], left[BLOCK] = {0}, right[BLOCK] = {0};
    float *const outputs[] = {left, right};
    const aula_signal signal = {1, input}; /* source 1: the first of the scene */
    for (int n = 0; n < count; ++n) {
        input[n] = p->sound[p->at]; /* the scene has its gain */
        p->at = (p->at + 1) % p->length;
    }
    aula_room_process(p->room, &signal, 1, outputs, 2, count);
    for (int n = 0; n < count; ++n) {
        pairs[2 * n] = left[n];
        pairs[2 * n + 1] = right[n];
        p->peak = fmaxf(p->peak, fmaxf(fabsf(left[n]), fabsf(right[n])));
    }
}

/* [audio thread] */
static void play(ma_device *device, void *output, const void *input, ma_uint32 count) {
    (void)input;
    for (ma_uint32 done = 0; done < count; done += BLOCK)
        render(device->pUserData, (float *)output + 2 * done,
               (int)(count - done < BLOCK ? count - done : BLOCK));
}

int main(int argc, char **argv) {
    const struct timespec between = {0, 1000000000 / POSES_HZ};
    aula_options options = {.size = sizeof options, .sample_rate_hz = RATE_HZ, .max_sources = 1};
    aula_status status = {.size = sizeof status};
    aula_scene *scene;
    player p = {0};
    float centre[3];
    stop_on(argc == 6 ? 0 : 2, "usage: SCENE SOUND X Y Z");
    for (int i = 0; i < 3; ++i)
        stop_on(sscanf(argv[3 + i], "%f", &centre[i]) == 1 ? 0 : 2, "expected X Y Z in metres");
    ma_decoder_config mono = ma_decoder_config_init(ma_format_f32, 1, RATE_HZ);
    require_ma(ma_decode_file(argv[2], &mono, &p.length, (void **)&p.sound), 2, argv[2]);
    stop_on(p.length == 0 ? 2 : 0, "the sound is empty");
    require(aula_scene_load(argv[1], &scene));
    stop_on(aula_scene_source_name(scene, 1) != NULL ? 0 : 2, "the scene has no source");
    aula_pose pose = walk(centre, 0);
    require(aula_scene_set_listener(scene, &pose));
    require(aula_room_create(scene, &options, &p.room));
    aula_scene_destroy(scene);

    ma_device device;
    ma_device_config stereo = ma_device_config_init(ma_device_type_playback);
    stereo.playback.format = ma_format_f32;
    stereo.playback.channels = 2;
    stereo.sampleRate = RATE_HZ;
    stereo.dataCallback = play;
    stereo.pUserData = &p;
    require_ma(ma_device_init(NULL, &stereo, &device), 1, "the output device");
    require_ma(ma_device_start(&device), 1, "the output device");
    int result = AULA_OK;
    for (int step = 0; step < SECONDS * POSES_HZ && result == AULA_OK; ++step) {
        pose = walk(centre, (double)step / POSES_HZ);
        result = aula_room_set_listener(p.room, 0, &pose, AULA_NOW);
        nanosleep(&between, NULL);
    }
    ma_device_uninit(&device); /* the audio thread has ended */
    require(result);
    require(aula_room_status(p.room, &status));
    printf("%.1f s, peak %.4f; %d propagation frames, %d of them late\n",
           (double)status.samples / RATE_HZ, p.peak, (int)status.frames, (int)status.late_frames);
    aula_room_destroy(p.room);
    ma_free(p.sound, NULL);
    return 0;
}
