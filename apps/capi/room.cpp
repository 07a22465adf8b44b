#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "apps/capi/handles.h"
#include "apps/capi/result.h"
#include "aula/engine/directivity.h"
#include "process/files.h"

namespace aula {

namespace {

// The memory of a room grows with both.
constexpr int32_t kMaxListeners = 64;
constexpr int32_t kMaxSources = 1024;

// No padding at the end, which a program built with an older header would leave undefined where a
// newer one has a member.
static_assert(offsetof(aula_options, headphones) + sizeof(aula_options::headphones) ==
              sizeof(aula_options));
static_assert(offsetof(aula_status, silent_pairs) + sizeof(aula_status::silent_pairs) ==
              sizeof(aula_status));

/// Throws InputError if the size with which a struct begins cannot be right.
void check_size(std::size_t size, const char* type) {
    constexpr std::size_t kLargest = 4096;
    if (size < sizeof(std::size_t) || size > kLargest)
        throw InputError(std::string("the size of ") + type + " is " + std::to_string(size) +
                         "; expected sizeof(" + type + ")");
}

/// A copy of a struct that begins with its size, of any version of the interface: members that the
/// caller does not know are 0. Throws InputError if the caller sets members that this library does
/// not know.
template <typename T>
T sized_copy(const T* given, const char* type) {
    check_size(given->size, type);
    const auto* const bytes = reinterpret_cast<const unsigned char*>(given);
    for (std::size_t i = sizeof(T); i < given->size; ++i)
        if (bytes[i] != 0)
            throw InputError(std::string("this version of Aula does not know a member of ") + type);
    T copy{};
    std::memcpy(&copy, given, std::min(given->size, sizeof(T)));
    return copy;
}

template <typename T>
T value_or(T value, T otherwise) {
    return value == 0 ? otherwise : value;
}

std::size_t count_or(int32_t count, std::size_t otherwise, int32_t max, const char* name) {
    if (count < 0 || count > max)
        throw InputError(std::string(name) + " is " + std::to_string(count) +
                         "; expected 0 (the default) to " + std::to_string(max));
    return count == 0 ? otherwise : static_cast<std::size_t>(count);
}

RenderClock clock_of(int32_t clock) {
    if (clock == AULA_REAL_TIME) return RenderClock::real_time;
    if (clock == AULA_EXACT) return RenderClock::exact;
    throw InputError("there is no clock " + std::to_string(clock) +
                     "; expected AULA_REAL_TIME or AULA_EXACT");
}

OutputFormat output_of(int32_t output) {
    switch (output) {
        case AULA_BINAURAL:
            return OutputFormat::binaural;
        case AULA_MONO:
            return OutputFormat::mono;
        case AULA_FOA:
            return OutputFormat::foa;
        case AULA_TOA:
            return OutputFormat::toa;
        default:
            throw InputError("there is no output " + std::to_string(output) +
                             "; expected AULA_BINAURAL, AULA_MONO, AULA_FOA or AULA_TOA");
    }
}

AuralizerOptions options_of(const aula_options& given, const Scene& scene) {
    AuralizerOptions options;
    options.clock = clock_of(given.clock);
    options.sample_rate_hz = value_or(given.sample_rate_hz, options.sample_rate_hz);
    options.block = value_or(given.block, options.block);
    options.output = output_of(given.output);
    options.ambisonic_order = value_or(given.ambisonic_order, options.ambisonic_order);
    if (given.hrtf != nullptr) options.hrtf = utf8_path(given.hrtf);
    if (given.headphones != nullptr) options.headphones = utf8_path(given.headphones);
    options.half_precision_tail = given.half_precision_tail != 0;
    options.listeners = count_or(given.listeners, options.listeners, kMaxListeners, "listeners");
    options.max_sources =
        count_or(given.max_sources, options.max_sources, kMaxSources, "max_sources");
    options.max_memory_bytes = value_or(given.max_memory_bytes, options.max_memory_bytes);
    if (given.follow_paths != 0) options.before_frame = follow_paths(scene);
    return options;
}

/// Replaces what the options set of the scene's simulation.
void set_simulation(const aula_options& given, Simulation& simulation) {
    if (given.frame_rate_hz != 0)
        simulation.frame_rate_hz = static_cast<float>(given.frame_rate_hz);
    if (given.ir_length_s != 0) simulation.ir_length_s = static_cast<float>(given.ir_length_s);
    if (given.rays != 0) simulation.rays = given.rays;
    if (given.threads != 0) simulation.threads = given.threads;
}

/// The auralizer of a room whose propagation has not failed; else throws its error.
template <typename Room>
auto& running(Room* room) {
    auto& auralizer = not_null(room, "room").auralizer;
    static_cast<void>(auralizer.status());
    return auralizer;
}

/// Throws InputError if a source is not present.
SourceId present(const Auralizer& auralizer, aula_source source) {
    const std::vector<SourceId> sources = auralizer.sources();
    const SourceId id{source};
    if (std::find(sources.begin(), sources.end(), id) == sources.end())
        throw InputError("source " + std::to_string(source) + " is not present");
    return id;
}

/// The index of a listener. Throws InputError if there is none.
std::size_t listener_index(int32_t listener, std::size_t listeners) {
    if (listener < 0 || static_cast<std::size_t>(listener) >= listeners)
        throw InputError("there is no listener " + std::to_string(listener));
    return static_cast<std::size_t>(listener);
}

/// The transform of three rows of four numbers.
RigidTransform transform_of(const float* transform) {
    const float* const rows = &not_null(transform, "transform");
    RigidTransform rigid;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            rigid.rotation[column][row] = rows[4 * row + column];
        rigid.translation[row] = rows[4 * row + 3];
    }
    return rigid;
}

/// What is wrong with the arguments of a call that renders; null if nothing. [wait-free]
const char* render_error(const aula_room* room, RenderClock clock, const aula_signal* inputs,
                         std::size_t input_count, float* const* outputs, std::size_t output_count,
                         int32_t samples) {
    if (room == nullptr) return "room is null";
    if (room->clock != clock)
        return clock == RenderClock::exact
                   ? "the room has AULA_REAL_TIME; expected aula_room_process()"
                   : "the room has AULA_EXACT; expected aula_room_process_exactly()";
    if (inputs == nullptr && input_count > 0) return "inputs is null";
    if (input_count > room->signals.size()) return "there are more than max_sources inputs";
    if (outputs == nullptr) return "outputs is null";
    if (output_count != room->auralizer.output_channels())
        return "output_count is not the room's number of channels";
    for (std::size_t c = 0; c < output_count; ++c)
        if (outputs[c] == nullptr) return "an output is null";
    if (samples < 0) return "the number of samples is negative";
    return nullptr;
}

/// Renders with checked arguments.
void render(aula_room& room, const aula_signal* inputs, std::size_t input_count,
            float* const* outputs, std::size_t output_count, int32_t samples) {
    for (std::size_t i = 0; i < input_count; ++i)
        room.signals[i] = {{inputs[i].source}, inputs[i].samples};
    room.auralizer.render({room.signals.data(), input_count}, {outputs, output_count}, samples);
}

}  // namespace

}  // namespace aula

aula_room::aula_room(const aula::Scene& scene, const aula_options& given_in,
                     aula::AuralizerOptions options)
    : given(given_in),
      clock(options.clock),
      listeners(options.listeners),
      signals(std::max(options.max_sources, scene.sources.size())),
      auralizer(scene, std::move(options)) {}

int aula_room_create(const aula_scene* scene, const aula_options* options, aula_room** room) {
    return aula::result_of([&] {
        aula::not_null(room, "room") = nullptr;
        aula::Scene changed = aula::not_null(scene, "scene").scene;
        const aula_options given =
            options != nullptr ? aula::sized_copy(options, "aula_options") : aula_options{};
        aula::set_simulation(given, changed.simulation);
        *room = new aula_room(changed, given, aula::options_of(given, changed));
    });
}

int aula_room_set_scene(aula_room* room, const aula_scene* scene, int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        aula::Scene changed = aula::not_null(scene, "scene").scene;
        aula::set_simulation(room->given, changed.simulation);
        auralizer.set_scene(changed, at);
    });
}

void aula_room_destroy(aula_room* room) { delete room; }

int aula_room_add_source(aula_room* room, const aula_pose* pose, const char* directivity,
                         int64_t at, aula_source* source) {
    return aula::result_of([&] {
        aula::not_null(source, "source") = 0;
        aula::Auralizer& auralizer = aula::running(room);
        const aula::Pose given = aula::pose_of(pose);
        *source = auralizer
                      .add_source({.position = given.position,
                                   .yaw_rad = given.yaw_rad,
                                   .pitch_rad = given.pitch_rad,
                                   .roll_rad = given.roll_rad,
                                   .directivity = aula::directivity_of(directivity)},
                                  at)
                      .number;
    });
}

int aula_room_remove_source(aula_room* room, aula_source source, int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        auralizer.remove_source(aula::present(auralizer, source), at);
    });
}

int aula_room_set_source(aula_room* room, aula_source source, const aula_pose* pose, int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        auralizer.set_source(aula::present(auralizer, source), aula::pose_of(pose), at);
    });
}

int aula_room_set_gain(aula_room* room, aula_source source, float gain_db, int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        auralizer.set_gain(aula::present(auralizer, source), gain_db, at);
    });
}

int aula_room_set_listener(aula_room* room, int32_t listener, const aula_pose* pose, int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        auralizer.set_listener(aula::listener_index(listener, room->listeners), aula::pose_of(pose),
                               at);
    });
}

int aula_room_set_transform(aula_room* room, size_t object, const float* transform, int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        auralizer.set_transform(object, aula::transform_of(transform), at);
    });
}

int aula_room_set_transform_by_name(aula_room* room, const char* object, const float* transform,
                                    int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        const std::string name = &aula::not_null(object, "object");
        auralizer.set_transform(name, aula::transform_of(transform), at);
    });
}

int aula_room_set_material(aula_room* room, size_t object, const char* material, int64_t at) {
    return aula::result_of([&] {
        aula::running(room).set_material(object, std::string(&aula::not_null(material, "material")),
                                         at);
    });
}

int aula_room_set_material_by_name(aula_room* room, const char* object, const char* material,
                                   int64_t at) {
    return aula::result_of([&] {
        aula::Auralizer& auralizer = aula::running(room);
        const std::string name = &aula::not_null(object, "object");
        auralizer.set_material(name, std::string(&aula::not_null(material, "material")), at);
    });
}

int aula_room_commit(aula_room* room, int64_t until) {
    return aula::result_of([&] { aula::running(room).commit(until); });
}

int aula_room_process(aula_room* room, const aula_signal* inputs, size_t input_count,
                      float* const* outputs, size_t output_count, int32_t samples) {
    const char* const error = aula::render_error(room, aula::RenderClock::real_time, inputs,
                                                 input_count, outputs, output_count, samples);
    if (error != nullptr) return aula::fail_wait_free(AULA_INPUT_ERROR, error);
    aula::render(*room, inputs, input_count, outputs, output_count, samples);
    return AULA_OK;
}

int aula_room_process_exactly(aula_room* room, const aula_signal* inputs, size_t input_count,
                              float* const* outputs, size_t output_count, int32_t samples) {
    return aula::result_of([&] {
        const char* const error = aula::render_error(room, aula::RenderClock::exact, inputs,
                                                     input_count, outputs, output_count, samples);
        if (error != nullptr) throw aula::InputError(error);
        aula::render(*room, inputs, input_count, outputs, output_count, samples);
    });
}

int aula_room_status(const aula_room* room, aula_status* status) {
    return aula::result_of([&] {
        aula_status& written = aula::not_null(status, "status");
        const aula::Auralizer& auralizer = aula::running(room);
        const std::size_t size = written.size;
        aula::check_size(size, "aula_status");
        const aula::AuralizerStatus now = auralizer.status();
        const aula_status all{
            .size = size,
            .samples = now.samples,
            .frames = now.frames,
            .late_frames = now.late_frames,
            .frame_ms = now.frame_ms,
            .frame_mean_ms = now.frame_mean_ms,
            .frame_worst_ms = now.frame_worst_ms,
            .frame_period_ms = now.frame_period_ms,
            .frame_age_s = now.frame_age_s,
            .response_length_s = now.response_length_s,
            .tail_samples = auralizer.tail_samples(),
            .memory_bytes = now.memory_bytes,
            .rays = now.rays,
            .channels = static_cast<int32_t>(auralizer.output_channels()),
            .latency_samples = auralizer.latency_samples(),
            .sources = static_cast<int32_t>(auralizer.sources().size()),
            .skipped_frames = now.skipped_frames,
            .muted_samples = now.muted_samples,
            .silent_pairs = now.silent_pairs,
        };
        std::memcpy(&written, &all, std::min(size, sizeof(all)));
    });
}

int aula_room_is_silent(const aula_room* room, aula_source source, int32_t listener, int* silent) {
    return aula::result_of([&] {
        aula::not_null(silent, "silent") = 0;
        const aula::Auralizer& auralizer = aula::running(room);
        *silent = auralizer.silent(aula::present(auralizer, source),
                                   aula::listener_index(listener, room->listeners))
                      ? 1
                      : 0;
    });
}

int aula_room_impulse_response(const aula_room* room, aula_source source, int32_t listener,
                               float* buffer, size_t capacity, size_t* length) {
    return aula::result_of([&] {
        aula::not_null(length, "length") = 0;
        const aula::Auralizer& auralizer = aula::running(room);
        if (capacity > 0) aula::not_null(buffer, "buffer");
        const auto response = auralizer.impulse_response(
            aula::present(auralizer, source), aula::listener_index(listener, room->listeners));
        const std::size_t channels = auralizer.output_channels() / room->listeners;
        std::fill_n(buffer, channels * capacity, 0.0F);
        for (std::size_t c = 0; c < response.size(); ++c)
            std::copy_n(response[c].data(), std::min(capacity, response[c].size()),
                        buffer + c * capacity);
        if (!response.empty()) *length = response[0].size();
    });
}
