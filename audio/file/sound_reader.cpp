// A program that decodes a sound file from standard input and writes a SoundHeader and blocks of
// samples to standard output. It is embedded in the library and run by read_sound().

#include <cstdlib>

#include "audio/file/sound_decoder.h"
#include "process/contained_program.h"

int main() {
    aula::decode_sound(aula::contain(), aula::write_bytes);
    std::_Exit(0);
}
