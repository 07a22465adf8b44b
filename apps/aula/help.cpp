#include "apps/aula/arguments.h"

namespace aula {

const char* help_text() {
    return R"(Aula plays rooms: it traces sound through a scene and lets you hear it where you stand.

usage: aula SCENE [options]                play live on the audio device
       aula SCENE --offline OUT.wav        render the walk to a file
       aula SCENE --ir OUT.wav --report    measure at the listener's first pose
       aula info SCENE                     what the room is: size, surface, reverberation time
       aula check SCENE                    read all files, say all that is wrong
       aula materials [list]               the materials that ship with Aula
       aula materials show NAME            one of them, its curves drawn

SCENE is a JSON file (docs/scene_format.md). A file named like a command is opened as ./info.
The listener follows the scene's path; you walk with w a s d and the arrow keys. In the window ?
shows the keys (docs/app.md); in the terminal q ends.

examples
  aula scenes/two_rooms.json --offline out.wav
  aula scenes/church.json --device pulse
  aula scenes/shoebox.json --report=room.json --position 5,4,1.7

what to do (--ir, --echogram and --report may be combined)
  --offline OUT.wav      render to a WAV file, as fast as the machine can; same seed, same bytes
  --ir OUT.wav           impulse response, sample 0 is emission; several sources: OUT-NAME.wav
  --echogram OUT.csv     energy response per octave band in 1/m2 for unit emitted energy
  --report[=OUT.json]    ISO 3382 parameters: a table on stdout, with a name also as JSON
  --frames N             measure over N frames (default: until the standard errors of level, C80,
                         T30, EDT are 0.05 dB, 0.1 dB, 1 %, 1 % in each octave, at most 2000)
  --bin-ms MS            width of the echogram's bins (1)
  --list-devices         list the output devices

where things are (metres, x front, y left, z up)
  --position X,Y,Z               a standing listener there instead of the scene's
  --source-position NAME=X,Y,Z   a source at rest there; may be repeated

simulation (goes before what the scene says; defaults in brackets)
  --estimator NAME       pt, dpc-published, dpc or patch [patch]
  --rays N               rays per source and frame [1000; live fewer until it keeps up]
  --order N              highest reflection order; 0: no limit [0]
  --specular-order N     highest order of the image sources [3]
  --response-time S      how long a cache remembers after a change, tau, in seconds [0.5]
  --patch-size M         size of the patches, lambda, in metres [0.5]
  --listener-radius M    radius of the detector sphere of pt and dpc in metres [0.5]
  --frame-rate HZ        propagation frames per second [30]
  --ir-length S          length of the responses in seconds, at most 10 [from the room, at most 4;
                         live shorter until it keeps up]
  --seed N               of all random numbers [1]
  --threads N            for tracing [all processors but one]
  --memory-mb N          for the caches [256]

sound
  --output FORMAT        binaural, mono (omnidirectional) or foa (AmbiX, ACN/SN3D) [binaural]
  --ambisonic-order N    of the reverberation for the ears, 1 to 3: sharper and dearer [1]
  --half-precision-tail  late reverberation from 16-bit filters: half the memory, -74 dB of error
  --hrtf FILE.sofa       head-related impulse responses [those of libmysofa, MIT KEMAR]
  --format FORMAT        of --offline: float, pcm24 or pcm16; a limiter guards pcm [float]
  --sample-rate HZ       [48000]
  --block FRAMES         samples rendered at a time, a power of two [256]
  --duration S           exactly that long [to the end of the path or of the longest unlooped
                         signal and until the room has rung out; only loops: one round; else 10]
  --device NAME|INDEX    output device: its number or a part of its name; none: in silence
                         [the default one]

window and remote control
  --no-window            play in the terminal
  --scene-dir FOLDER     scenes to go through with page up and page down
  --screenshot OUT.png   play for a while, write a picture of the window, end
  --after S              that while, in seconds [5]
  --osc [ADDRESS:]PORT   listen for OSC messages, by default from this machine only

other
  --quiet                only errors, and what was asked for
  --version, --help

exit status: 0 done, 1 failed while running (no device, disk full), 2 bad arguments or input,
130 after Ctrl-C (a second one does not wait for a frame or a file), 143 after SIGTERM
)";
}

}  // namespace aula
