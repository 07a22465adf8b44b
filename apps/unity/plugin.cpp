// What the library exports for Unity, beside the functions of aula.h.

#include <aula.h>

#include <algorithm>
#include <cstring>

#include "apps/unity/effects.h"
#include "apps/unity/room_player.h"
#include "process/module.h"

#if defined(_WIN32)
#define AULA_EXPORT extern "C" __declspec(dllexport)
#else
#define AULA_EXPORT extern "C" __attribute__((visibility("default")))
#endif

using namespace aula::unity;

/// Call it before the other functions. Returns AULA_FAILURE if a library is missing in the folder
/// of this one.
AULA_EXPORT int aula_unity_prepare();
int aula_unity_prepare() { return aula::prepare_module() ? AULA_OK : AULA_FAILURE; }

/// Plays a room on the clock AULA_REAL_TIME with binaural output from now on; null: none. When it
/// returns, the room before may be destroyed.
AULA_EXPORT void aula_unity_play(aula_room* room);
void aula_unity_play(aula_room* room) { RoomPlayer::get().play(room); }

/// 1 if a room plays and the mixer has an effect that renders it, else 0.
AULA_EXPORT int aula_unity_is_heard();
int aula_unity_is_heard() { return RoomPlayer::get().is_heard() ? 1 : 0; }

/// Writes the newest problem of a source or the listener, one line, as much of it as `size` bytes
/// hold with the zero at its end, and forgets it. Returns 0 if there is none.
AULA_EXPORT int aula_unity_take_problem(char* text, int size);
int aula_unity_take_problem(char* text, int size) {
    const std::string problem = RoomPlayer::get().take_problem();
    if (problem.empty() || size < 1) return 0;
    const std::size_t length = std::min(problem.size(), static_cast<std::size_t>(size) - 1);
    std::memcpy(text, problem.data(), length);
    text[length] = 0;
    return 1;
}

/// The effects, as Unity calls it. Returns their number.
AULA_EXPORT int UnityGetAudioEffectDefinitions(EffectDefinition*** definitions);
int UnityGetAudioEffectDefinitions(EffectDefinition*** definitions) {
    static EffectDefinition effects[] = {spatializer(), room_effect()};
    static EffectDefinition* pointers[] = {&effects[0], &effects[1]};
    RoomPlayer::get();  // made here, not on the audio thread
    *definitions = pointers;
    return aula::prepare_module() ? 2 : 0;
}
