/* A source that clicks once per second and moves through a room, in C99:
 *
 *     moving_source SCENE SOURCE             plays it on the default output device (PortAudio)
 *     moving_source SCENE SOURCE OUT.f32     writes it to a file: left, right, left, ... as floats
 *
 * SOURCE is the name of a source of the scene, for instance
 *     moving_source scenes/shoebox.json castanets
 *
 * cc -std=c99 moving_source.c $(pkg-config --cflags --libs aula portaudio-2.0) -o moving_source */
#include <aula.h>
#include <portaudio.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RATE_HZ = 48000, SECONDS = 4, FRAME_RATE_HZ = 32, BLOCK = RATE_HZ / FRAME_RATE_HZ };

typedef struct {
    aula_room *room;
    aula_source source;
    int64_t time; /* samples played, used by the audio thread */
} player;

static void stop_on(int failed, const char *message) {
    if (!failed) return;
    fprintf(stderr, "moving_source: %s\n", message);
    exit(failed == AULA_INPUT_ERROR ? 2 : 1);
}

static void require(int result) { stop_on(result, aula_message()); }

/* 1 m/s along x. */
static aula_pose pose_at(double time_s) {
    aula_pose pose = {{2, 2, 1.5F}, 0, 0, 0};
    pose.position[0] += (float)(time_s < SECONDS ? time_s : SECONDS);
    return pose;
}

static void make_clicks(int64_t time, float *samples, int count) {
    memset(samples, 0, (size_t)count * sizeof(float));
    for (int n = 0; n < count; ++n)
        if ((time + n) % RATE_HZ == 0) samples[n] = 1;
}

/* [audio thread] */
static int play_block(const void *input, void *output, unsigned long count,
                      const PaStreamCallbackTimeInfo *times, PaStreamCallbackFlags flags,
                      void *user) {
    player *p = user;
    float clicks[BLOCK];
    aula_signal signal = {p->source, clicks};
    (void)input, (void)times, (void)flags;
    make_clicks(p->time, clicks, (int)count);
    p->time += (int64_t)count;
    if (aula_room_process(p->room, &signal, 1, output, 2, (int32_t)count) != AULA_OK)
        return paAbort;
    return p->time < (int64_t)SECONDS * RATE_HZ ? paContinue : paComplete;
}

static void play(player *p) {
    PaStream *stream;
    PaError error = Pa_Initialize();
    if (error == paNoError)
        error = Pa_OpenDefaultStream(&stream, 0, 2, paFloat32 | paNonInterleaved, RATE_HZ, BLOCK,
                                     play_block, p);
    if (error == paNoError) error = Pa_StartStream(stream);
    stop_on(error != paNoError, Pa_GetErrorText(error));
    while (Pa_IsStreamActive(stream) == 1) {
        aula_status status = {.size = sizeof(status)};
        require(aula_room_status(p->room, &status));
        aula_pose pose = pose_at((double)status.samples / RATE_HZ);
        require(aula_room_set_source(p->room, p->source, &pose, AULA_NOW));
        Pa_Sleep(10);
    }
    Pa_Terminate();
}

static void write_file(player *p, const char *name) {
    static float clicks[BLOCK], left[BLOCK], right[BLOCK];
    float *const outputs[2] = {left, right};
    aula_signal signal = {p->source, clicks};
    aula_status status = {.size = sizeof(status)};
    FILE *file = fopen(name, "wb");
    stop_on(file == NULL, "the file cannot be written");
    require(aula_room_status(p->room, &status));
    const int64_t end = (int64_t)SECONDS * RATE_HZ + status.latency_samples;
    for (int64_t time = 0; time < end; time += BLOCK) {
        aula_pose pose = pose_at((double)time / RATE_HZ);
        require(aula_room_set_source(p->room, p->source, &pose, time));
        make_clicks(time, clicks, BLOCK);
        require(aula_room_process_exactly(p->room, &signal, 1, outputs, 2, BLOCK));
        for (int n = 0; n < BLOCK; ++n) {
            if (time + n < status.latency_samples || time + n >= end) continue;
            fwrite(&left[n], sizeof(float), 1, file);
            fwrite(&right[n], sizeof(float), 1, file);
        }
    }
    stop_on(ferror(file) || fclose(file) != 0, "the file cannot be written");
}

int main(int argc, char **argv) {
    aula_scene *scene;
    player p = {NULL, 0, 0};
    aula_options options = {.size = sizeof(options)};
    stop_on(argc < 3 || argc > 4 ? AULA_INPUT_ERROR : 0, "usage: SCENE SOURCE [OUT.f32]");
    options.sample_rate_hz = RATE_HZ;
    options.max_sources =
        1; /* the more, the fewer early reflections of each source move smoothly */
    options.frame_rate_hz = FRAME_RATE_HZ;
    options.clock = argc == 4 ? AULA_EXACT : AULA_REAL_TIME;
    require(aula_scene_load(argv[1], &scene));
    require(aula_scene_find_source(scene, argv[2], &p.source));
    require(aula_room_create(scene, &options, &p.room));
    aula_scene_destroy(scene);
    if (argc == 4)
        write_file(&p, argv[3]);
    else
        play(&p);
    aula_room_destroy(p.room);
    return 0;
}
