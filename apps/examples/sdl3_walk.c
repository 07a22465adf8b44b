/* A room in a program with SDL 3, in C99: a sound comes from the first source of a scene, and the
 * listener walks a circle with a radius of 0.5 m about a place, for 6 s:
 *
 *     sdl3_walk SCENE SOUND.wav X Y Z
 *     sdl3_walk scenes/shoebox.json scenes/sounds/castanets.wav 6 5 1.7
 *
 * cc -std=c99 sdl3_walk.c $(pkg-config --cflags --libs aula sdl3) -lm -o sdl3_walk */
#include <SDL3/SDL.h>
#include <aula.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { RATE_HZ = 48000, SECONDS = 6, POSES_HZ = 60, BLOCK = 256 /* the default of aula_options */ };
enum { PAIR = (int)(2 * sizeof(float)) /* bytes of a sample of both ears */ };

typedef struct {
    aula_room *room;
    float *sound;
    size_t length, at; /* samples of the sound, the next one */
    float peak;        /* of what has been played */
} player;

static void stop_on(int failed, const char *message) {
    if (!failed) return;
    fprintf(stderr, "sdl3_walk: %s\n", message);
    exit(failed);
}

static void require(int result) { stop_on(result, aula_message()); }
static void require_sdl(bool done, int failed) { stop_on(done ? 0 : failed, SDL_GetError()); }

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

/* [audio thread] SDL calls it with its lock of the stream. */
static void SDLCALL play(void *user, SDL_AudioStream *stream, int bytes, int total_bytes) {
    float pairs[2 * BLOCK];
    (void)total_bytes;
    for (int count = bytes / PAIR; count > 0; count -= BLOCK) {
        render(user, pairs, count < BLOCK ? count : BLOCK);
        SDL_PutAudioStreamData(stream, pairs, PAIR * (count < BLOCK ? count : BLOCK));
    }
}

static void read_sound(const char *file, player *p) {
    const SDL_AudioSpec mono = {SDL_AUDIO_F32, 1, RATE_HZ};
    SDL_AudioSpec spec;
    Uint8 *data, *samples;
    Uint32 bytes;
    int converted;
    require_sdl(SDL_LoadWAV(file, &spec, &data, &bytes), 2);
    require_sdl(SDL_ConvertAudioSamples(&spec, data, (int)bytes, &mono, &samples, &converted), 2);
    SDL_free(data);
    p->sound = (float *)(void *)samples;
    p->length = (size_t)converted / sizeof(float);
    stop_on(p->length == 0 ? 2 : 0, "the sound is empty");
}

int main(int argc, char **argv) {
    const SDL_AudioSpec stereo = {SDL_AUDIO_F32, 2, RATE_HZ};
    aula_options options = {.size = sizeof options, .sample_rate_hz = RATE_HZ, .max_sources = 1};
    aula_status status = {.size = sizeof status};
    aula_scene *scene;
    player p = {0};
    float centre[3];
    stop_on(argc == 6 ? 0 : 2, "usage: SCENE SOUND.wav X Y Z");
    for (int i = 0; i < 3; ++i)
        stop_on(sscanf(argv[3 + i], "%f", &centre[i]) == 1 ? 0 : 2, "expected X Y Z in metres");
    require_sdl(SDL_Init(SDL_INIT_AUDIO), 1);
    read_sound(argv[2], &p);
    require(aula_scene_load(argv[1], &scene));
    stop_on(aula_scene_source_name(scene, 1) != NULL ? 0 : 2, "the scene has no source");
    aula_pose pose = walk(centre, 0);
    require(aula_scene_set_listener(scene, &pose));
    require(aula_room_create(scene, &options, &p.room));
    aula_scene_destroy(scene);

    SDL_AudioStream *stream =
        SDL_OpenAudioDeviceStream(SDL_AUDIO_DEVICE_DEFAULT_PLAYBACK, &stereo, play, &p);
    require_sdl(stream != NULL && SDL_ResumeAudioStreamDevice(stream), 1);
    int result = AULA_OK;
    for (int step = 0; step < SECONDS * POSES_HZ && result == AULA_OK; ++step) {
        pose = walk(centre, (double)step / POSES_HZ);
        result = aula_room_set_listener(p.room, 0, &pose, AULA_NOW);
        SDL_DelayNS(SDL_NS_PER_SECOND / POSES_HZ);
    }
    SDL_DestroyAudioStream(stream); /* the audio thread has ended */
    require(result);
    require(aula_room_status(p.room, &status));
    printf("%.1f s, peak %.4f; %d propagation frames, %d of them late\n",
           (double)status.samples / RATE_HZ, p.peak, (int)status.frames, (int)status.late_frames);
    aula_room_destroy(p.room);
    SDL_free(p.sound);
    SDL_Quit();
    return 0;
}
