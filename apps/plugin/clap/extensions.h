#pragma once

#include <clap/plugin.h>

#include <cstdint>

// Extensions of CLAP 1 that Debian's dpf-source lacks, as CLAP defines them (MIT licence, copyright
// 2021 Alexandre Bique).

namespace aula::plugin {

inline constexpr const char* kRenderExtension = "clap.render";

/// Whether the host plays or renders offline. [main thread]
struct RenderExtension {
    enum Mode : std::int32_t { real_time = 0, offline = 1 };

    bool(CLAP_ABI* has_hard_realtime_requirement)(const clap_plugin_t* plugin);
    bool(CLAP_ABI* set)(const clap_plugin_t* plugin, std::int32_t mode);
};

inline constexpr const char* kTailExtension = "clap.tail";

/// Samples of sound after the input has ended. [main and audio thread]
struct TailExtension {
    std::uint32_t(CLAP_ABI* get)(const clap_plugin_t* plugin);
};

/// The second name is that of CLAP 1.1.
inline constexpr const char* kAmbisonicExtension = "clap.ambisonic/3";
inline constexpr const char* kAmbisonicDraft = "clap.ambisonic.draft/3";
inline constexpr const char* kAmbisonicPort = "ambisonic";

struct AmbisonicConfig {
    static constexpr std::uint32_t kAcn = 1;
    static constexpr std::uint32_t kSn3d = 1;

    std::uint32_t ordering;
    std::uint32_t normalization;
};

/// The convention of ambisonic ports. [main thread]
struct AmbisonicExtension {
    bool(CLAP_ABI* is_config_supported)(const clap_plugin_t* plugin, const AmbisonicConfig* config);
    bool(CLAP_ABI* get_config)(const clap_plugin_t* plugin, bool is_input, std::uint32_t port,
                               AmbisonicConfig* config);
};

inline constexpr const char* kLogExtension = "clap.log";

/// The log of a host. [any thread]
struct HostLog {
    enum Severity : std::int32_t { information = 1, warning = 2 };

    void(CLAP_ABI* log)(const clap_host_t* host, std::int32_t severity, const char* text);
};

}  // namespace aula::plugin
