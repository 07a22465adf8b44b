#include "apps/godot/bus.h"

#include <algorithm>
#include <utility>

namespace aula::godot {
namespace {

/// What the effects on the channels of one bus share.
struct BusChannels {
    std::shared_ptr<BusProcessor> processor;
    /// The effect of the first pair of channels, which the engine processes first.
    const void* first = nullptr;
};

class BusEffect final : public Instance {
 public:
    using Instance::Instance;
    std::shared_ptr<BusChannels> channels = std::make_shared<BusChannels>();
};

class BusEffectInstance final : public Instance {
 public:
    using Instance::Instance;
    ~BusEffectInstance() override {
        if (channels && channels->first == this) channels->first = nullptr;
    }

    /// [audio thread, wait-free]
    void process(const StereoSample* from, StereoSample* to, int count) noexcept {
        if (channels && channels->first == nullptr) channels->first = this;
        if (channels && channels->first == this && channels->processor)
            channels->processor->process(from, to, count);
        else
            std::fill_n(to, count, StereoSample{0, 0});
    }

    std::shared_ptr<BusChannels> channels;
};

Object server() { return Object::singleton("AudioServer"); }

}  // namespace

Bus::Bus(std::string name, std::shared_ptr<BusProcessor> processor, const std::string& send)
    : name_(std::move(name)) {
    const Value effect(Object::construct("AulaBusEffect"));
    instance_of<BusEffect>(effect.to_object())->channels->processor = std::move(processor);
    const Object audio = server();
    audio.call("add_bus", -1);
    const std::int64_t index = audio.call("get_bus_count").to_int() - 1;
    audio.call("set_bus_name", index, name_);
    audio.call("set_bus_send", index, send);
    audio.call("add_bus_effect", index, effect, -1);
}

Bus::~Bus() {
    const std::int64_t index = server().call("get_bus_index", name_).to_int();
    if (index > 0) server().call("remove_bus", index);
}

void Bus::send_to(const std::string& bus) {
    const std::int64_t index = server().call("get_bus_index", name_).to_int();
    if (index > 0) server().call("set_bus_send", index, bus);
}

AudioLock::AudioLock() { server().call("lock"); }

AudioLock::~AudioLock() { server().call("unlock"); }

std::unique_ptr<ClassEntry> register_bus_effect() {
    auto entry = std::make_unique<ClassEntry>(
        "AulaBusEffect", "AudioEffect",
        [](Object object) -> Instance* { return new BusEffect(object); }, false, false);
    entry->add_virtual("_instantiate",
                       [](void* self, const GDExtensionConstTypePtr*, void* result) {
                           const Object instance = Object::construct("AulaBusEffectInstance");
                           instance_of<BusEffectInstance>(instance)->channels =
                               static_cast<BusEffect*>(static_cast<Instance*>(self))->channels;
                           api.ref_set_object(result, instance.pointer);
                       });
    return entry;
}

std::unique_ptr<ClassEntry> register_bus_effect_instance() {
    auto entry = std::make_unique<ClassEntry>(
        "AulaBusEffectInstance", "AudioEffectInstance",
        [](Object object) -> Instance* { return new BusEffectInstance(object); }, false, false);
    entry->add_virtual("_process", [](void* self, const GDExtensionConstTypePtr* arguments, void*) {
        const auto* from = *static_cast<const StereoSample* const*>(arguments[0]);
        auto* to = *static_cast<StereoSample* const*>(arguments[1]);
        const auto count = *static_cast<const std::int64_t*>(arguments[2]);
        static_cast<BusEffectInstance*>(static_cast<Instance*>(self))
            ->process(from, to, static_cast<int>(count));
    });
    entry->add_virtual(
        "_process_silence", [](void* self, const GDExtensionConstTypePtr*, void* result) {
            const auto& instance = *static_cast<BusEffectInstance*>(static_cast<Instance*>(self));
            *static_cast<GDExtensionBool*>(result) =
                instance.channels && instance.channels->processor &&
                instance.channels->processor->processes_silence();
        });
    return entry;
}

}  // namespace aula::godot
