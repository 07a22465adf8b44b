/* aula~: a room in Pure Data, with an inlet for the sound of each source, over <aula.h>.
 *
 *     [aula~ FLAGS SCENE SOURCE ...]
 *
 * SCENE is a scene file, in the folder of the patch or in Pd's path, each SOURCE the name of one of
 * its sources. Flags: -mono, -foa, -toa (outputs; else left and right ear), -exact (renders as
 * `aula --offline` does and waits for it, for `pd -batch`).
 *
 * Messages to the left inlet, in metres and degrees; angles that are left out are 0:
 *     source NAME X Y Z [YAW PITCH ROLL]
 *     listener X Y Z [YAW PITCH ROLL]
 *     gain NAME DB */
#include <aula.h>
#include <m_pd.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define MOST_SOURCES 64 /* inlets of an object */
#define MOST_OUTPUTS 16

typedef struct {
    t_symbol *name;
    aula_source number;
    aula_pose pose;
    t_float gain_db;
    int is_moved, has_gain;
    t_sample *from; /* of the inlet, in the present DSP chain */
} inlet_source;

typedef struct {
    t_object object;
    t_float scalar; /* of the left inlet, for Pd */
    aula_scene *scene;
    aula_room *room;
    aula_options options;
    inlet_source sources[MOST_SOURCES];
    int source_count, output_count;
    aula_pose listener;
    int is_listener_moved;
    int64_t time; /* rendered samples of the room */
    /* Of the present DSP chain. Outlets may have the memory of inlets, which is therefore copied.
     */
    t_sample *copies, *to[MOST_OUTPUTS];
    int block;
} t_aula;

static t_class *aula_class;

/* A change takes effect with the next block. */
static int64_t at(const t_aula *x) { return x->options.clock == AULA_EXACT ? x->time : AULA_NOW; }

/* Says on Pd's console what a function of the library objects to. */
static int failed(t_aula *x, int result) {
    if (result != AULA_OK) pd_error(x, "aula~: %s", aula_message());
    return result != AULA_OK;
}

/* Makes the room for a sample rate, with what the messages have changed. */
static void make_room(t_aula *x, double rate_hz) {
    aula_room_destroy(x->room);
    x->room = NULL;
    x->time = 0;
    x->options.sample_rate_hz = rate_hz;
    if (failed(x, aula_room_create(x->scene, &x->options, &x->room))) return;
    if (x->is_listener_moved) aula_room_set_listener(x->room, 0, &x->listener, at(x));
    for (int s = 0; s < x->source_count; ++s) {
        const inlet_source *source = &x->sources[s];
        if (source->is_moved) aula_room_set_source(x->room, source->number, &source->pose, at(x));
        if (source->has_gain)
            aula_room_set_gain(x->room, source->number, (float)source->gain_db, at(x));
    }
}

static t_int *perform(t_int *w) {
    t_aula *x = (t_aula *)w[1];
    aula_signal signals[MOST_SOURCES];
    int result = AULA_FAILURE;
    for (int s = 0; s < x->source_count; ++s) {
        t_sample *copy = x->copies + (size_t)s * (size_t)x->block;
        memcpy(copy, x->sources[s].from, (size_t)x->block * sizeof(t_sample));
        signals[s].source = x->sources[s].number;
        signals[s].samples = copy;
    }
    if (x->room != NULL)
        result = (x->options.clock == AULA_EXACT ? aula_room_process_exactly : aula_room_process)(
            x->room, signals, (size_t)x->source_count, x->to, (size_t)x->output_count, x->block);
    for (int o = 0; o < x->output_count && result != AULA_OK; ++o)
        memset(x->to[o], 0, (size_t)x->block * sizeof(t_sample));
    x->time += x->block;
    return w + 2;
}

static void dsp(t_aula *x, t_signal **sp) {
    const int block = sp[0]->s_n;
    const size_t old_bytes = (size_t)x->source_count * (size_t)x->block * sizeof(t_sample);
    const size_t bytes = (size_t)x->source_count * (size_t)block * sizeof(t_sample);
    x->copies = resizebytes(x->copies, old_bytes, bytes);
    x->block = block;
    for (int s = 0; s < x->source_count; ++s) x->sources[s].from = sp[s]->s_vec;
    for (int o = 0; o < x->output_count; ++o) x->to[o] = sp[x->source_count + o]->s_vec;
    if (x->room == NULL || x->options.sample_rate_hz != (double)sp[0]->s_sr)
        make_room(x, (double)sp[0]->s_sr);
    dsp_add(perform, 1, x);
}

/* A pose of three or six numbers. */
static int read_pose(t_aula *x, const char *message, int argc, const t_atom *argv,
                     aula_pose *pose) {
    const float radians = 3.14159265358979F / 180;
    float numbers[6] = {0};
    int usable = argc == 3 || argc == 6;
    for (int i = 0; i < argc && usable; ++i) {
        usable = argv[i].a_type == A_FLOAT;
        if (usable) numbers[i] = (float)argv[i].a_w.w_float;
    }
    if (!usable) {
        pd_error(x,
                 "aula~: %s: expected three coordinates in metres, or these and three angles "
                 "in degrees",
                 message);
        return 0;
    }
    memcpy(pose->position, numbers, sizeof pose->position);
    pose->yaw_rad = numbers[3] * radians;
    pose->pitch_rad = numbers[4] * radians;
    pose->roll_rad = numbers[5] * radians;
    return 1;
}

/* The source that the first atom of a message names. */
static inlet_source *named_source(t_aula *x, int argc, const t_atom *argv) {
    const t_symbol *name = argc > 0 && argv[0].a_type == A_SYMBOL ? argv[0].a_w.w_symbol : NULL;
    for (int s = 0; s < x->source_count; ++s)
        if (x->sources[s].name == name) return &x->sources[s];
    pd_error(x, "aula~: no inlet has the source \"%s\"", name != NULL ? name->s_name : "");
    return NULL;
}

static void move_source(t_aula *x, t_symbol *message, int argc, t_atom *argv) {
    inlet_source *source = named_source(x, argc, argv);
    aula_pose pose;
    if (source == NULL || !read_pose(x, message->s_name, argc - 1, argv + 1, &pose)) return;
    if (x->room != NULL && failed(x, aula_room_set_source(x->room, source->number, &pose, at(x))))
        return;
    source->pose = pose;
    source->is_moved = 1;
}

static void move_listener(t_aula *x, t_symbol *message, int argc, t_atom *argv) {
    aula_pose pose;
    if (!read_pose(x, message->s_name, argc, argv, &pose)) return;
    if (x->room != NULL && failed(x, aula_room_set_listener(x->room, 0, &pose, at(x)))) return;
    x->listener = pose;
    x->is_listener_moved = 1;
}

static void set_gain(t_aula *x, t_symbol *message, int argc, t_atom *argv) {
    inlet_source *source = named_source(x, argc, argv);
    if (source == NULL) return;
    if (argc != 2 || argv[1].a_type != A_FLOAT) {
        pd_error(x, "aula~: %s: expected a number of decibels", message->s_name);
        return;
    }
    const t_float gain_db = argv[1].a_w.w_float;
    if (x->room != NULL &&
        failed(x, aula_room_set_gain(x->room, source->number, (float)gain_db, at(x))))
        return;
    source->gain_db = gain_db;
    source->has_gain = 1;
}

static void destroy(t_aula *x) {
    aula_room_destroy(x->room);
    aula_scene_destroy(x->scene);
    freebytes(x->copies, (size_t)x->source_count * (size_t)x->block * sizeof(t_sample));
}

/* Takes a flag. */
static int read_flag(t_aula *x, const char *flag) {
    static const char *const names[] = {"-binaural", "-mono", "-foa", "-toa"};
    if (strcmp(flag, "-exact") == 0) {
        x->options.clock = AULA_EXACT;
        return 1;
    }
    for (int output = AULA_MONO; output <= AULA_TOA; ++output) {
        if (strcmp(flag, names[output]) != 0) continue;
        x->options.output = output;
        return 1;
    }
    pd_error(x, "aula~: unknown flag %s; expected -exact, -mono, -foa or -toa", flag);
    return 0;
}

/* Loads a scene from the folder of the patch or Pd's path; else by the name as it is, for the
 * library's message. */
static int load_scene(t_aula *x, const char *name) {
    char folder[MAXPDSTRING], file[2 * MAXPDSTRING], *found;
    const int descriptor =
        canvas_open(canvas_getcurrent(), name, "", folder, &found, MAXPDSTRING, 1);
    if (descriptor >= 0) {
        close(descriptor);
        snprintf(file, sizeof file, "%s/%s", folder, found);
    }
    return !failed(x, aula_scene_load(descriptor >= 0 ? file : name, &x->scene));
}

/* Adds an inlet for a source of the scene. */
static int add_inlet(t_aula *x, t_symbol *name) {
    inlet_source *source = &x->sources[x->source_count];
    if (x->source_count == MOST_SOURCES) {
        pd_error(x, "aula~: more than %d sources", MOST_SOURCES);
        return 0;
    }
    source->name = name;
    for (int k = 0; k < x->source_count; ++k) {
        if (x->sources[k].name != name) continue;
        pd_error(x, "aula~: two inlets for the source %s", name->s_name);
        return 0;
    }
    if (failed(x, aula_scene_find_source(x->scene, name->s_name, &source->number))) return 0;
    ++x->source_count;
    return 1;
}

/* Reads the arguments of an object; false, and a line on Pd's console, if they cannot be used. */
static int read_arguments(t_aula *x, int argc, t_atom *argv) {
    const char *of_scene;
    for (int i = 0; i < argc; ++i) {
        t_symbol *name = argv[i].a_type == A_SYMBOL ? argv[i].a_w.w_symbol : NULL;
        if (name == NULL) {
            pd_error(x, "aula~: a number among the arguments; expected names");
            return 0;
        }
        if (x->scene == NULL && name->s_name[0] == '-') {
            if (!read_flag(x, name->s_name)) return 0;
        } else if (!(x->scene == NULL ? load_scene(x, name->s_name) : add_inlet(x, name))) {
            return 0;
        }
    }
    if (x->scene == NULL) {
        pd_error(x, "aula~: expected a scene file");
        return 0;
    }
    if (x->source_count > 0) return 1;
    for (aula_source s = 1; (of_scene = aula_scene_source_name(x->scene, s)) != NULL; ++s)
        if (!add_inlet(x, gensym(of_scene))) return 0;
    return 1;
}

static void *create(t_symbol *name, int argc, t_atom *argv) {
    static const int channels[] = {2, 1, 4, 16}; /* of the outputs */
    t_aula *x = (t_aula *)pd_new(aula_class);
    (void)name;
    x->scene = NULL;
    x->room = NULL;
    memset(&x->options, 0, sizeof x->options);
    x->options.size = sizeof x->options;
    x->options.max_sources = 1; /* those of the scene */
    memset(x->sources, 0, sizeof x->sources);
    x->source_count = 0;
    x->is_listener_moved = 0;
    x->copies = getbytes(0);
    x->block = 0;
    if (read_arguments(x, argc, argv)) make_room(x, (double)sys_getsr());
    if (x->room == NULL) {
        pd_free(&x->object.ob_pd);
        return NULL;
    }
    x->output_count = channels[x->options.output];
    for (int s = 1; s < x->source_count; ++s)
        inlet_new(&x->object, &x->object.ob_pd, &s_signal, &s_signal);
    for (int o = 0; o < x->output_count; ++o) outlet_new(&x->object, &s_signal);
    return x;
}

AULA_API void aula_tilde_setup(void);
void aula_tilde_setup(void) {
    aula_class = class_new(gensym("aula~"), (t_newmethod)create, (t_method)destroy, sizeof(t_aula),
                           CLASS_DEFAULT, A_GIMME, A_NULL);
    CLASS_MAINSIGNALIN(aula_class, t_aula, scalar);
    class_addmethod(aula_class, (t_method)dsp, gensym("dsp"), A_CANT, A_NULL);
    class_addmethod(aula_class, (t_method)move_source, gensym("source"), A_GIMME, A_NULL);
    class_addmethod(aula_class, (t_method)move_listener, gensym("listener"), A_GIMME, A_NULL);
    class_addmethod(aula_class, (t_method)set_gain, gensym("gain"), A_GIMME, A_NULL);
}
