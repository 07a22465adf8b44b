#include "tests/plugin/vst3/vst3_host.h"

#include <travesty/factory.h>

#include <algorithm>
#include <cstring>

#include "tests/plugin/shared_library.h"

namespace aula::test {

namespace {

v3_plugin_factory_2** factory() {
    static v3_plugin_factory_2** const found = [] {
        const SharedLibrary library(AULA_VST3_BINARY);
#if defined(_WIN32)
        const auto enter = library.find<bool (*)()>("InitDll");
        demand(enter != nullptr && enter(), "no entry");
#else
        const auto enter = library.find<bool (*)(void*)>("ModuleEntry");
        demand(enter != nullptr && enter(library.handle()), "no entry");
#endif
        const auto get = library.find<void* (*)()>("GetPluginFactory");
        demand(get != nullptr, "no factory");
        auto** const first = static_cast<v3_plugin_factory**>(get());
        v3_plugin_factory_2** second = nullptr;
        v3_cpp_obj_query_interface(first, v3_plugin_factory_2_iid, &second);
        demand(second != nullptr, "no factory");
        return second;
    }();
    return found;
}

/// An object of the host: its functions first.
template <typename Functions, typename Data>
struct HostObject {
    const Functions* functions;
    Data data;

    static Data& of(void* self) { return static_cast<HostObject*>(self)->data; }
};

v3_result no_interface(void*, const v3_tuid, void**) { return V3_NO_INTERFACE; }
std::uint32_t no_count(void*) { return 1; }
constexpr v3_funknown kUnknown{no_interface, no_count, no_count};

/// A change in a queue of its own.
using Queue = HostObject<v3_param_value_queue_cpp, Vst3Change>;

const v3_param_value_queue_cpp kQueue = [] {
    v3_param_value_queue_cpp functions{};
    static_cast<v3_funknown&>(functions) = kUnknown;
    functions.queue = {
        [](void* self) { return static_cast<v3_param_id>(Queue::of(self).control); },
        [](void*) -> std::int32_t { return 1; },
        [](void* self, std::int32_t, std::int32_t* sample, double* value) -> v3_result {
            *sample = static_cast<std::int32_t>(Queue::of(self).sample);
            *value = Queue::of(self).value;
            return V3_OK;
        },
        nullptr};
    return functions;
}();

using Changes = HostObject<v3_param_changes_cpp, std::vector<Queue>>;

const v3_param_changes_cpp kChanges = [] {
    v3_param_changes_cpp functions{};
    static_cast<v3_funknown&>(functions) = kUnknown;
    functions.changes = {
        [](void* self) { return static_cast<std::int32_t>(Changes::of(self).size()); },
        [](void* self, std::int32_t index) {
            return reinterpret_cast<v3_param_value_queue**>(
                &Changes::of(self)[static_cast<std::size_t>(index)]);
        },
        nullptr};
    return functions;
}();

struct Bytes {
    std::string text;
    std::size_t done = 0;
};
struct StreamFunctions : v3_funknown {
    v3_bstream stream;
};
using Stream = HostObject<StreamFunctions, Bytes>;

/// Streams of hosts may take less than what is asked for.
constexpr std::int32_t kMostBytes = 7;

const StreamFunctions kStream = [] {
    StreamFunctions functions{};
    static_cast<v3_funknown&>(functions) = kUnknown;
    functions.stream = {
        [](void* self, void* to, std::int32_t size, std::int32_t* read) -> v3_result {
            Bytes& bytes = Stream::of(self);
            *read = std::min(
                {size, kMostBytes, static_cast<std::int32_t>(bytes.text.size() - bytes.done)});
            std::memcpy(to, bytes.text.data() + bytes.done, static_cast<std::size_t>(*read));
            bytes.done += static_cast<std::size_t>(*read);
            return V3_OK;
        },
        [](void* self, void* from, std::int32_t size, std::int32_t* written) -> v3_result {
            *written = std::min(size, kMostBytes);
            Stream::of(self).text.append(static_cast<const char*>(from),
                                         static_cast<std::size_t>(*written));
            return V3_OK;
        },
        nullptr, nullptr};
    return functions;
}();

}  // namespace

Vst3Host::Vst3Host(const std::string& name) {
    v3_plugin_factory_2** const plugins = factory();
    const auto& first = *v3_cpp_obj(reinterpret_cast<v3_plugin_factory**>(plugins));
    for (std::int32_t i = 0; i < first.num_classes(plugins); ++i) {
        v3_class_info_2 info;
        demand(v3_cpp_obj(plugins)->get_class_info_2(plugins, i, &info) == V3_OK, "no class");
        if (name == info.name)
            first.create_instance(plugins, info.class_id, v3_component_iid,
                                  reinterpret_cast<void**>(&component_));
    }
    demand(component_ != nullptr, "no instance");
    demand(v3_cpp_obj_initialize(component_, nullptr) == V3_OK, "no initialization");
    v3_cpp_obj_query_interface(component_, v3_audio_processor_iid, &processor_);
    v3_cpp_obj_query_interface(component_, v3_edit_controller_iid, &controller_);
    demand(processor_ != nullptr && controller_ != nullptr, "no interface");
}

Vst3Host::~Vst3Host() {
    v3_cpp_obj_terminate(component_);
    v3_cpp_obj_unref(controller_);
    v3_cpp_obj_unref(processor_);
    v3_cpp_obj_unref(component_);
}

v3_result Vst3Host::set_up(bool is_offline, double rate_hz) const {
    v3_process_setup setup{is_offline ? V3_OFFLINE : V3_REALTIME, V3_SAMPLE_32, 8192, rate_hz};
    return v3_cpp_obj(processor_)->setup_processing(processor_, &setup);
}

Channels Vst3Host::run(const Channels& input, std::size_t size,
                       const std::vector<Vst3Change>& changes) const {
    v3_bus_info bus;
    v3_cpp_obj(component_)->get_bus_info(component_, V3_AUDIO, V3_OUTPUT, 0, &bus);
    Channels from = input;
    Channels output(static_cast<std::size_t>(bus.channel_count),
                    std::vector<float>(input[0].size()));
    std::size_t done = 0;
    do {
        const std::size_t samples = std::min(size, input[0].size() - done);
        std::vector<float*> in;
        std::vector<float*> out;
        for (std::vector<float>& channel : from) in.push_back(channel.data() + done);
        for (std::vector<float>& channel : output) out.push_back(channel.data() + done);
        Changes block{&kChanges, {}};
        for (Vst3Change change : changes) {
            const bool is_last = done + samples == input[0].size();
            if (change.sample < done || (change.sample >= done + samples && !is_last)) continue;
            change.sample -= done;
            block.data.push_back({&kQueue, change});
        }
        v3_audio_bus_buffers inputs{static_cast<std::int32_t>(in.size()), 0, {in.data()}};
        v3_audio_bus_buffers outputs{static_cast<std::int32_t>(out.size()), 0, {out.data()}};
        v3_process_data data{};
        data.process_mode = V3_OFFLINE;
        data.nframes = static_cast<std::int32_t>(samples);
        data.num_input_buses = data.num_output_buses = 1;
        data.inputs = &inputs;
        data.outputs = &outputs;
        data.input_params = reinterpret_cast<v3_param_changes**>(&block);
        if (v3_cpp_obj(processor_)->process(processor_, &data) != V3_OK) return {};
        done += size;
    } while (done < input[0].size());
    return output;
}

std::string Vst3Host::save() const {
    Stream stream{&kStream, {}};
    auto** const to = reinterpret_cast<v3_bstream**>(&stream);
    return v3_cpp_obj(component_)->get_state(component_, to) == V3_OK ? stream.data.text : "";
}

bool Vst3Host::load(const std::string& state) const {
    Stream stream{&kStream, {state}};
    auto** const from = reinterpret_cast<v3_bstream**>(&stream);
    return v3_cpp_obj(component_)->set_state(component_, from) == V3_OK;
}

}  // namespace aula::test
