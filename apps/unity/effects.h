#pragma once

#include "apps/unity/audio_interface.h"

namespace aula::unity {

/// Parameters of the spatializer.
enum class Parameter { gain_db, directivity };

/// Takes the sound of a source into the room. Where no room is heard it passes the sound on.
EffectDefinition spatializer();

/// Adds the sound of the room to that of a group of the mixer.
EffectDefinition room_effect();

}  // namespace aula::unity
