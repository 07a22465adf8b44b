#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "apps/python/arrays.h"
#include "aula/audio/output_options.h"
#include "aula/engine/scene.h"
#include "aula/exception.h"

namespace aula {

/// Settings of one call in place of the scene's.
struct Overrides {
    std::optional<std::uint64_t> seed;
    std::optional<int> rays;
    std::optional<float> ir_length_s;
    std::optional<Array<float>> speech_db;  ///< a level in dB(A), or 8 octave levels
    std::optional<Array<float>> noise_db;   ///< 8 octave levels
    int threads = 1;
};

/// A copy of the scene with these settings.
inline Scene with(const Scene& scene, const Overrides& overrides) {
    Scene changed = scene;
    Simulation& simulation = changed.simulation;
    if (overrides.seed) simulation.seed = *overrides.seed;
    if (overrides.rays) simulation.rays = overrides.rays;
    if (overrides.ir_length_s) simulation.ir_length_s = overrides.ir_length_s;
    simulation.threads = overrides.threads;
    if (const auto& speech = overrides.speech_db)
        changed.speech.speech_db = speech->size() == 1
                                       ? SpeechConditions::male_speech_db(*speech->data())
                                       : bands_of(*speech);
    if (overrides.noise_db) changed.speech.noise_db = bands_of(*overrides.noise_db);
    simulation.check();
    return changed;
}

/// An output format by its name.
inline OutputFormat output_of(const std::string& name) {
    for (const auto& [known, format] : kOutputFormats)
        if (name == known) return format;
    throw InputError("output: \"" + name + "\"; expected mono, foa, toa or binaural");
}

/// The settings of an output.
inline OutputOptions output_options(double sample_rate_hz, const std::string& output,
                                    const std::string& hrtf, int ambisonic_order) {
    OutputOptions options;
    options.sample_rate_hz = sample_rate_hz;
    options.output = output_of(output);
    options.hrtf = hrtf;
    options.ambisonic_order = ambisonic_order;
    return options;
}

}  // namespace aula
