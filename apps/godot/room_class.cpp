#include "apps/godot/room_node.h"

namespace aula::godot {
namespace {

using Measure = double (*)(const RoomNode&);

struct Measurement {
    const char* name;
    const char* suffix;
    Measure value;
};

/// What a room costs: shown by the inspector of a running game, and as monitors.
constexpr std::array kMeasurements{
    Measurement{"frame_ms", "ms", [](const RoomNode& room) { return room.status().frame_ms; }},
    Measurement{"frame_period_ms", "ms",
                [](const RoomNode& room) { return room.status().frame_period_ms; }},
    Measurement{
        "late_frames", "",
        [](const RoomNode& room) { return static_cast<double>(room.status().late_frames); }},
    Measurement{"audio_load_percent", "%", [](const RoomNode& room) { return 100 * room.load(); }},
    Measurement{"cache_mb", "MB",
                [](const RoomNode& room) {
                    return static_cast<double>(room.status().memory_bytes) * 1e-6;
                }},
    Measurement{"response_length_s", "s",
                [](const RoomNode& room) { return room.status().response_length_s; }},
};

/// The name of a monitor: its category is that of the room.
std::string monitor(Object room, const Measurement& measurement) {
    return "Aula " + room.call("get_name").to_string() + "/" + measurement.name;
}

}  // namespace

void RoomNode::add_monitors() {
    const Object performance = Object::singleton("Performance");
    for (const Measurement& measurement : kMeasurements) {
        const std::string name = monitor(object(), measurement);
        if (performance.call("has_custom_monitor", name).to_bool()) continue;
        const std::string getter = std::string("get_") + measurement.name;
        performance.call("add_custom_monitor", name, Value::callable(object(), getter.c_str()));
        monitors_.push_back(name);
    }
}

void RoomNode::remove_monitors() {
    const Object performance = Object::singleton("Performance");
    for (const std::string& name : monitors_) performance.call("remove_custom_monitor", name);
    monitors_.clear();
}

std::unique_ptr<ClassEntry> register_room() {
    using Node = RoomNode;
    auto entry = std::make_unique<ClassEntry>(
        "AulaRoom", "Node3D", [](Object object) -> Instance* { return new RoomNode(object); }, true,
        true);
    entry->add_property(
        material_property("material"),
        method_of<Node>([](Node& self, const Value*) { return self.material_value; }),
        method_of<Node>(
            [](Node& self, const Value* a) { return self.material_value = a[0], Value(); }));
    entry->add_property({.name = "rays",
                         .type = GDEXTENSION_VARIANT_TYPE_INT,
                         .hint = 1,  // PROPERTY_HINT_RANGE
                         .hint_string = "0,200000"},
                        method_of<Node>([](Node& self, const Value*) { return Value(self.rays); }),
                        method_of<Node>([](Node& self, const Value* a) {
                            return self.rays = static_cast<int>(a[0].to_int()), Value();
                        }));
    entry->add_property(
        {.name = "ir_length_s",
         .type = GDEXTENSION_VARIANT_TYPE_FLOAT,
         .hint = 1,  // PROPERTY_HINT_RANGE
         .hint_string = "0,10,0.1,suffix:s"},
        method_of<Node>([](Node& self, const Value*) { return Value(self.ir_length_s); }),
        method_of<Node>([](Node& self, const Value* a) {
            return self.ir_length_s = a[0].to_double(), Value();
        }));
    for (const Measurement& measurement : kMeasurements) {
        const Measure value = measurement.value;
        entry->add_property(
            {.name = measurement.name,
             .type = GDEXTENSION_VARIANT_TYPE_FLOAT,
             .hint_string = *measurement.suffix == 0 ? std::string()
                                                     : std::string("suffix:") + measurement.suffix,
             .usage = 4 | 268435456},  // PROPERTY_USAGE_EDITOR, PROPERTY_USAGE_READ_ONLY
            method_of<Node>([value](Node& self, const Value*) { return Value(value(self)); }), {});
    }
    entry->add_method("rebuild", method_of<Node>([](Node& self, const Value*) {
                          return self.rebuild(), Value();
                      }));
    entry->add_method("save_scene", method_of<Node>([](Node& self, const Value* arguments) {
                          return Value(self.save(arguments[0].to_string()));
                      }),
                      {.name = "", .type = GDEXTENSION_VARIANT_TYPE_BOOL},
                      {{.name = "file", .type = GDEXTENSION_VARIANT_TYPE_STRING}});
    return entry;
}

}  // namespace aula::godot
