/* Rooms in Csound, over <aula.h>:
 *
 *     iroom aularoom Sscene [, Soutput, iclock]
 *     a1 [, a2 ...] aula iroom, asource1 [, asource2 ...]
 *     aulasource iroom, Sname, kx, ky, kz [, kyaw, kpitch, kroll]
 *     aulalistener iroom, kx, ky, kz [, kyaw, kpitch, kroll]
 *
 * aularoom makes a room of a scene file, in the header of the orchestra or in an instrument, with
 * which it ends. Soutput: "binaural" (left and right ear, the default), "mono", "foa" or "toa".
 * aula renders a room from the sounds of its sources, in the order of the scene file. The others
 * move a source or the head, in metres and degrees.
 *
 * On the exact clock (iclock 1) a room renders as `aula --offline` does and waits for it, on the
 * real-time clock (0) nothing waits. By default (-1) the clock is exact if Csound writes to a named
 * file. Csound does not tell its opcodes whether a host plays the sound instead. */
#include <aula.h>
#include <csdl.h>
#include <string.h>

#define MOST_OUTPUTS 16

typedef struct room {
    struct room *next;
    int number; /* for the orchestra; from 1 on, never that of an earlier room */
    aula_scene *scene;
    aula_room *room;
    aula_options options;
    const void *player; /* the opcode aula that renders it */
    int source_count, channels;
} room;

/* The rooms of a Csound. */
typedef struct {
    room *first;
    int last_number;
} room_list;

typedef struct {
    OPDS h;
    MYFLT *number;
    STRINGDAT *file, *output; /* the latter and the clock if there are three inputs */
    MYFLT *clock;
    room *made; /* until the note ends; its number may not be that of the variable any more */
} opcode_room;

typedef struct {
    OPDS h;
    MYFLT *outputs[MOST_OUTPUTS], *number, *inputs[VARGMAX];
    AUXCH signals; /* aula_signal of each source */
    AUXCH samples; /* of inputs, then of outputs */
    int room;      /* its number when the note began; 0: none */
} opcode_aula;

/* What moves a source or the listener. */
typedef struct {
    int room;           /* its number when the note began */
    aula_source source; /* 0: the listener */
    aula_pose pose;
    int is_set;
} mover;

typedef struct {
    OPDS h;
    MYFLT *number;
    STRINGDAT *name;
    MYFLT *pose[6];
    mover mover;
} opcode_source;

typedef struct {
    OPDS h;
    MYFLT *number, *pose[6];
    mover mover;
} opcode_listener;

static const char list_name[] = "aula_rooms";

/* The room of a number; null if there is none. */
static room *find_room(CSOUND *csound, MYFLT number) {
    const room_list *list = csound->QueryGlobalVariable(csound, list_name);
    room *r = list != NULL ? list->first : NULL;
    while (r != NULL && (MYFLT)r->number != number) r = r->next;
    return r;
}

static int no_room(CSOUND *csound, MYFLT number) {
    return csound->InitError(csound, "there is no room %g; expected that of aularoom", number);
}

/* Whether a file name of Csound's options is that of a device: NAME, NAME2, NAME:text. */
static int is_device(const char *file, const char *name) {
    const size_t length = strlen(name);
    const char *rest;
    if (file == NULL || strncmp(file, name, length) != 0) return 0;
    rest = file + length;
    return *rest == ':' || rest[strspn(rest, "0123456789")] == '\0';
}

/* Whether Csound writes to a named file and records from no device. If a host implements input and
 * output, no file is named, unless options that the host does not use name one. */
static int writes_file(CSOUND *csound) {
    OPARMS options;
    csound->GetOParms(csound, &options);
    return options.sfwrite != 0 && options.outfilename != NULL &&
           !is_device(options.outfilename, "dac") && !is_device(options.outfilename, "devaudio") &&
           !is_device(options.infilename, "adc") && !is_device(options.infilename, "devaudio");
}

static int end_room(CSOUND *csound, void *opcode) {
    room_list *list = csound->QueryGlobalVariable(csound, list_name);
    room **link = &list->first, *r = ((opcode_room *)opcode)->made;
    if (r == NULL) return OK;
    while (*link != r) link = &(*link)->next;
    *link = r->next;
    aula_room_destroy(r->room);
    aula_scene_destroy(r->scene);
    csound->Free(csound, r);
    ((opcode_room *)opcode)->made = NULL;
    return OK;
}

/* Sets the outputs of a room; false if there are none of this name. */
static int read_output(room *r, const char *name) {
    static const char *const names[] = {"binaural", "mono", "foa", "toa"};
    static const int channels[] = {2, 1, 4, 16};
    for (int output = AULA_BINAURAL; output <= AULA_TOA; ++output) {
        if (strcmp(name, names[output]) != 0) continue;
        r->options.output = output;
        r->channels = channels[output];
        return 1;
    }
    return 0;
}

static int make_room(CSOUND *csound, opcode_room *p) {
    room_list *list = csound->QueryGlobalVariable(csound, list_name);
    const int has_output = csound->GetInputArgCnt(p) > 1;
    const char *output = has_output ? p->output->data : "binaural";
    const MYFLT clock = has_output ? *p->clock : -1;
    OPARMS csound_options;
    char *found;
    room *r;
    int result;
    csound->GetOParms(csound, &csound_options);
    if (csound_options.realtime) /* notes begin in one thread and play in another */
        return csound->InitError(csound, "--realtime is not supported");
    if (list == NULL) {
        csound->CreateGlobalVariable(csound, list_name, sizeof(room_list));
        list = csound->QueryGlobalVariable(csound, list_name);
    }
    if (p->made == NULL)
        csound->RegisterDeinitCallback(csound, p, end_room);
    else
        end_room(csound, p); /* a pass of reinit */
    r = csound->Calloc(csound, sizeof(room));
    r->number = ++list->last_number;
    r->next = list->first;
    list->first = p->made = r;
    *p->number = r->number;
    if (!read_output(r, output))
        return csound->InitError(
            csound, "unknown output \"%s\"; expected one of binaural, mono, foa and toa", output);
    if (clock != -1 && clock != 0 && clock != 1)
        return csound->InitError(csound, "unknown clock %g; expected one of -1, 0 and 1", clock);
    r->options.size = sizeof r->options;
    r->options.max_sources = 1; /* those of the scene */
    r->options.sample_rate_hz = csound->GetSr(csound);
    r->options.clock =
        clock == 1 || (clock == -1 && writes_file(csound)) ? AULA_EXACT : AULA_REAL_TIME;
    found = csound->FindInputFile(csound, p->file->data, "SSDIR;INCDIR");
    result = aula_scene_load(found != NULL ? found : p->file->data, &r->scene);
    csound->Free(csound, found);
    if (result == AULA_OK) result = aula_room_create(r->scene, &r->options, &r->room);
    if (result != AULA_OK) return csound->InitError(csound, "%s", aula_message());
    while (aula_scene_source_name(r->scene, (aula_source)r->source_count + 1) != NULL)
        ++r->source_count;
    return OK;
}

static void leave_room(CSOUND *csound, const opcode_aula *p) {
    room *r = find_room(csound, p->room);
    if (r != NULL && r->player == p) r->player = NULL;
}

static int end_aula(CSOUND *csound, void *opcode) {
    leave_room(csound, opcode);
    ((opcode_aula *)opcode)->room = 0;
    return OK;
}

static int begin_aula(CSOUND *csound, opcode_aula *p) {
    room *r = find_room(csound, *p->number);
    const int inputs = csound->GetInputArgCnt(p) - 1, outputs = csound->GetOutputArgCnt(p);
    leave_room(csound, p); /* if this is a pass of reinit */
    if (r == NULL) return no_room(csound, *p->number);
    if (r->player != NULL)
        return csound->InitError(csound, "another aula plays room %d", r->number);
    if (inputs != r->source_count)
        return csound->InitError(
            csound, "the number of inputs is %d; expected %d, one for each source of the scene",
            inputs, r->source_count);
    if (outputs != r->channels)
        return csound->InitError(csound, "the number of outputs is %d; expected %d", outputs,
                                 r->channels);
    csound->AuxAlloc(csound, (size_t)inputs * sizeof(aula_signal), &p->signals);
    csound->AuxAlloc(csound, (size_t)(inputs + outputs) * CS_KSMPS * sizeof(float), &p->samples);
    if (p->room == 0) csound->RegisterDeinitCallback(csound, p, end_aula);
    p->room = r->number;
    r->player = p;
    return OK;
}

static int play(CSOUND *csound, opcode_aula *p) {
    const room *r = find_room(csound, p->room);
    const uint32_t first = p->h.insdshead->ksmps_offset; /* a note begins and ends at any sample */
    const uint32_t end = CS_KSMPS - p->h.insdshead->ksmps_no_end;
    const MYFLT full_scale = csound->Get0dBFS(csound);
    aula_signal *signals = p->signals.auxp;
    float *samples = p->samples.auxp, *outputs[MOST_OUTPUTS];
    int result;
    if (r == NULL || r->player != p)
        return csound->PerfError(csound, &p->h, "the room has ended, or plays another aula");
    for (int s = 0; s < r->source_count; ++s, samples += CS_KSMPS) {
        signals[s].source = (aula_source)s + 1;
        signals[s].samples = samples;
        for (uint32_t n = first; n < end; ++n)
            samples[n - first] = (float)(p->inputs[s][n] / full_scale);
    }
    for (int o = 0; o < r->channels; ++o, samples += CS_KSMPS) outputs[o] = samples;
    result = (r->options.clock == AULA_EXACT ? aula_room_process_exactly : aula_room_process)(
        r->room, signals, (size_t)r->source_count, outputs, (size_t)r->channels,
        (int32_t)(end - first));
    if (result != AULA_OK) return csound->PerfError(csound, &p->h, "%s", aula_message());
    for (int o = 0; o < r->channels; ++o) {
        memset(p->outputs[o], 0, CS_KSMPS * sizeof(MYFLT));
        for (uint32_t n = first; n < end; ++n)
            p->outputs[o][n] = outputs[o][n - first] * full_scale;
    }
    return OK;
}

/* Moves what has a new pose. A change takes effect with the next sample of the room. */
static int move(CSOUND *csound, OPDS *h, MYFLT *const *numbers, mover *m) {
    const MYFLT radians = 3.14159265358979323846 / 180;
    const room *r = find_room(csound, m->room);
    aula_pose pose;
    int result;
    if (r == NULL) return csound->PerfError(csound, h, "the room has ended");
    for (int i = 0; i < 3; ++i) pose.position[i] = (float)*numbers[i];
    pose.yaw_rad = (float)(*numbers[3] * radians);
    pose.pitch_rad = (float)(*numbers[4] * radians);
    pose.roll_rad = (float)(*numbers[5] * radians);
    if (m->is_set && memcmp(&pose, &m->pose, sizeof pose) == 0) return OK;
    result = m->source != 0 ? aula_room_set_source(r->room, m->source, &pose, AULA_NOW)
                            : aula_room_set_listener(r->room, 0, &pose, AULA_NOW);
    if (result != AULA_OK) return csound->PerfError(csound, h, "%s", aula_message());
    m->pose = pose;
    m->is_set = 1;
    return OK;
}

static int begin_source(CSOUND *csound, opcode_source *p) {
    const room *r = find_room(csound, *p->number);
    aula_source source;
    p->mover.room = 0; /* nothing moves after an error in a pass of reinit */
    if (r == NULL) return no_room(csound, *p->number);
    if (aula_scene_find_source(r->scene, p->name->data, &source) != AULA_OK)
        return csound->InitError(csound, "%s", aula_message());
    p->mover.room = r->number;
    p->mover.source = source;
    p->mover.is_set = 0;
    return OK;
}

static int move_source(CSOUND *csound, opcode_source *p) {
    return move(csound, &p->h, p->pose, &p->mover);
}

static int begin_listener(CSOUND *csound, opcode_listener *p) {
    const room *r = find_room(csound, *p->number);
    p->mover.room = 0;
    if (r == NULL) return no_room(csound, *p->number);
    p->mover.room = r->number;
    p->mover.source = 0;
    p->mover.is_set = 0;
    return OK;
}

static int move_listener(CSOUND *csound, opcode_listener *p) {
    return move(csound, &p->h, p->pose, &p->mover);
}

/* thread: 1 at the beginning, 2 in each control period. */
static OENTRY localops[] = {
    {"aularoom", sizeof(opcode_room), 0, 1, "i", "S", (SUBR)make_room, NULL, NULL, NULL},
    {"aularoom.output", sizeof(opcode_room), 0, 1, "i", "SSj", (SUBR)make_room, NULL, NULL, NULL},
    {"aula", sizeof(opcode_aula), 0, 3, "mmmmmmmmmmmmmmmm", "iy", (SUBR)begin_aula, (SUBR)play,
     NULL, NULL},
    {"aulasource", sizeof(opcode_source), 0, 3, "", "iSkkkOOO", (SUBR)begin_source,
     (SUBR)move_source, NULL, NULL},
    {"aulalistener", sizeof(opcode_listener), 0, 3, "", "ikkkOOO", (SUBR)begin_listener,
     (SUBR)move_listener, NULL, NULL},
};

LINKAGE
