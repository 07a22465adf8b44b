#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "apps/aula/arguments/arguments.h"

namespace aula {

namespace {

constexpr const char* kText =
    R"(Aula simulates room acoustics in real time: it propagates sound through a scene and plays
what arrives at the listener.

usage: aula SCENE [options]                play live on the audio device
       aula SCENE --offline OUT.wav        render the scene to a file
       aula SCENE --ir OUT.wav --report    measure at the listener's initial pose
       aula map SCENE --out DIR            map the ISO 3382 parameters of a room
       aula report SCENE --html OUT.html   write the ISO 3382 parameters, with plots, as a document
       aula analyse FILE.wav...            ISO 3382 parameters and STI of impulse responses
       aula info SCENE                     print size, surface area, reverberation time
       aula check SCENE                    read all files, print all errors
       aula import MODEL [--out SCENE.json]
                                           write the scene of a model, for editing
       aula materials [WORD]               list the materials that ship with Aula, or those whose
                                           names or sources hold it or which it means
       aula materials show NAME            print the coefficients of one of them as bars
       aula dataset plan|run|status|slurm|merge ...
                                           make many responses of random rooms (docs/datasets.md)

SCENE is a JSON file (docs/scene_format.md), or a model: OBJ, glTF, GLB, PLY or STL. What a model
does not say is guessed and printed (docs/from_model_to_sound.md). A file named like a command is opened as ./info. A name
without a slash that is no file is the name of a scene that ships: aula two_rooms.
The listener follows the path of the scene; w a s d and the arrow keys move it, in the terminal only
if it has no path. In the window ? shows the keys (docs/app.md); in the terminal q quits.

examples
  aula scenes/two_rooms.json --offline out.wav
  aula scenes/church.json --device pulse
  aula scenes/shoebox.json --report=room.json --position 5,4,1.7

modes (--ir, --echogram and --report may be combined)
  --offline OUT.wav      render to a WAV file, as fast as possible; same seed, same bytes
  --ir OUT.wav           impulse response, sample 0 is emission; several sources: OUT-NAME.wav
  --echogram OUT.csv     energy response per octave band in 1/m2 for unit emitted energy
  --report[=OUT.json]    ISO 3382 parameters: a table on stdout; with OUT.json also as JSON
  --third-octaves        of --report, map and report: T20 to G also in third octaves from 50 Hz to
                         16 kHz; maps have them in place of octaves
  --frames N             measure over N frames (default: until the standard errors of level, C80,
                         T30, EDT are 0.05 dB, 0.1 dB, 1 %, 1 % in each octave, at most 2000, and
                         as far as --quality allows)
  --speech-level DB      of the speech transmission index: dB(A) of male speech at 1 m on the
                         axis of a source, or 8 octave levels a,b,.. [the scene's, else 60]
  --noise-level DB       noise at the listener: one level for each octave, or 8 [the scene's]
  --bin-ms MS            width of the echogram's bins in milliseconds [1]
  --list-devices         list the output devices

map (with --frames, --speech-level, --noise-level, positions and simulation)
  --out DIR              folder of a picture and a table of each parameter and source: T30.png,
                         T30.csv; several sources: T30-NAME.png
  --height M             z of the receivers in metres [1.2]
  --surface NAME         receivers above the faces of a material or an object, such as raked seats
  --offset M             height of the receivers above these faces in metres [1.2]
  --spacing M            distance of the receivers in metres [0.5]
  --interaural           maps of IACC, too, which take about 0.3 s for each receiver and source

report (with --frames, --speech-level, --noise-level, positions and simulation)
  --html OUT.html        one file with plan, parameters, plots, conditions and materials
  --json OUT.json        the values of all pairs, their mean and standard deviation, too
  --project TEXT         lines of the head of the document [none]
  --client TEXT
  --author TEXT
  --date TEXT
  --receiver NAME=X,Y,Z  a receiver in place of the listener; may be repeated
  --measured FILE        measured values to compare with: a table, or a response that is analysed;
                         may be repeated (docs/room_measurements.md)

analyse (with --speech-level and --noise-level: at the microphone; without them STI has no levels)
  --third-octaves        also third octaves from 50 Hz to 16 kHz
  --out OUT.csv|.json    the values as a table, which can be read again, or as JSON

check
  --strict               exit 3 for every warning [only for those that make results meaningless:
                         more than 10 % of the reflections escape, the listener or all sources are
                         outside, no source is audible, another unit or vertical axis explains the
                         geometry, or it is too far from the origin]

import
  --out SCENE.json       the scene file, which must not exist [standard output]
  --scale S              metres per unit of the model [guessed]
  --up y|z               the vertical axis of the model [guessed; glTF: y]

positions (metres, x front, y left, z up)
  --position X,Y,Z               static listener at this position, in place of the scene's
  --source-position NAME=X,Y,Z   static source at this position; may be repeated

simulation (overrides the scene; defaults in brackets)
  --estimator NAME       pt, dpc-published, dpc or patch [patch]
  --quality NAME         time that is spent: draft, normal or fine. Of --offline: a second of sound
                         takes about 0.25 or 1 s on two processors, but at least 100 rays of all
                         sources, or as long as 1000 rays take. Of measurements: about 15 s, 1 min,
                         or until their errors are small [normal]
  --rays N               rays per source and frame [--offline: as --quality allows, at most 1000;
                         otherwise 1000; live 250 in draft quality, fewer if frames take too long]
  --order N              highest reflection order; 0: no limit [0]
  --specular-order N     highest order of the image sources [3]
  --response-time S      averaging time of the caches, tau, in seconds [0.5]
  --patch-size M         size of the patches, lambda, in metres [0.5]
  --listener-radius M    radius of the detection sphere of pt and dpc in metres [0.5]
  --frame-rate HZ        propagation frames per second [30]
  --ir-length auto|S     length of the responses in seconds, at most 10; auto: as long as the room
                         sounds [auto; live: shorter if frames take too long]
  --seed N               seed of all random numbers [1]
  --threads N            threads for tracing [all processors but one]
  --memory-mb N          memory of the caches in megabytes [256]

sound
  --output FORMAT        binaural, mono (omnidirectional), foa or toa (AmbiX, ACN/SN3D, of first
                         or third order) [binaural]
  --ambisonic-order N    order of the binaural reverberation, 1 to 3; a higher order resolves
                         directions better and costs more [1]
  --half-precision-tail  late reverberation from 16-bit filters: half the memory, error -74 dB
  --hrtf FILE.sofa       head-related impulse responses [MIT KEMAR]
  --headphones FILE.wav  impulse response with which binaural output is convolved: one channel for
                         both ears, or left and right, at most 4 s; 1.0 is the gain 1 [none]
  --format FORMAT        sample format of --offline: float, pcm24 or pcm16; pcm with a limiter
                         [float]
  --no-dither            pcm: rounding without dither [triangular dither from --seed]
  --sample-rate HZ       sample rate [48000]
  --block FRAMES         samples per block, a power of two [256]
  --duration S           exact duration in seconds [until the end of the path or of the longest
                         unlooped signal and of the reverberation; only loops: one cycle; else 10]
  --device NAME|INDEX    output device by its index or a part of its name; none: real time without
                         a device [the default device]

window and remote control
  --no-window            play in the terminal
  --scene-dir FOLDER     scenes that page up and page down open
  --screenshot OUT.png   play, write a picture of the window, exit
  --after S              time of the screenshot in seconds [5]
  --osc [ADDRESS:]PORT   receive OSC messages, and play until quit or for --duration; without
                         ADDRESS from this machine only
  --adm-origin X,Y,Z     position of the origin of ADM-OSC [the listener's first position]
  --adm-radius M         distance of its coordinate 1 [half of the room's longest side]
  --head-invert          head trackers send the inverse rotation, that of the scene

datasets
  plan MANIFEST --out DIR --shards N     draw the scenes of a manifest into DIR
  run DIR --shard K [--threads N]        compute shard K, from 0 on; threads [1]
  status DIR [--missing] [--verify]      count items and failures; only the missing shards;
                                         check the hashes of all items
  slurm DIR [--cpus N] [--time T] [--limit N]
                                         write scripts for Slurm: processors [1] and time
                                         [04:00:00] of a task, tasks at the same time [100]
  merge DIR --to hdf5|sofa|wav           write all items in order, with checksums

other
  --quiet                print errors and requested output only
  --version, --help      print the versions of aula and Embree, or this text

exit status: 0 done, 1 failure at run time (no device, disk full), 2 invalid arguments or input,
3 a scene that check doubts, 130 after Ctrl-C (a second one ends immediately), 143 after SIGTERM
)";

/// The paragraphs of a text; they are divided by empty lines.
std::vector<std::string_view> paragraphs_of(std::string_view text) {
    std::vector<std::string_view> paragraphs;
    for (;;) {
        const std::size_t end = text.find("\n\n");
        paragraphs.push_back(text.substr(0, end));
        if (end == text.npos) return paragraphs;
        text.remove_prefix(end + 2);
    }
}

/// The lines of the usage that concern a command.
std::string usage_of(std::string_view usage, const std::string& command) {
    std::string lines;
    bool is_of_command = false;
    while (!usage.empty()) {
        const std::size_t end = std::min(usage.find('\n'), usage.size() - 1);
        const std::string_view line = usage.substr(0, end + 1);
        constexpr std::size_t kCommand = 7;  // after "usage: "
        if (line.substr(kCommand).starts_with("aula "))
            is_of_command = line.substr(kCommand).starts_with("aula " + command + " ");
        if (is_of_command) lines += line;
        usage.remove_prefix(end + 1);
    }
    if (!lines.empty() && !lines.ends_with('\n')) lines += '\n';
    return lines;
}

}  // namespace

std::string help_text(const std::string& command) {
    if (command.empty()) return kText;
    const std::vector<std::string_view> paragraphs = paragraphs_of(kText);
    const std::string usage = usage_of(paragraphs[1], command);
    if (usage.empty()) return kText;
    std::string text = usage;
    // The section of the command names the other ones that hold for it.
    const auto add = [&](std::string_view heading) {
        for (const std::string_view paragraph : paragraphs)
            if (paragraph.starts_with(heading)) text += "\n" + std::string(paragraph) + "\n";
    };
    add(command == "dataset" ? "datasets" : command + " (");
    add(command + "\n");
    if (command == "map" || command == "report")
        for (const char* const heading : {"positions", "simulation"}) add(heading);
    add("other");
    return text;
}

}  // namespace aula
