#include "apps/godot/source_node.h"

#include <cstring>

#include "apps/godot/notifications.h"
#include "apps/godot/room_node.h"

namespace aula::godot {

void SourceNode::notified(int notification) {
    if (notification == kPostEnterTree) {
        enter();
    } else if (notification == kExitTree) {
        if (room_ != nullptr) {
            room_->remove(*this);
            leave();
        }
        starts_ = false;
    }
}

void SourceNode::enter() {
    object().call("add_to_group", kRoomPartsGroup);
    starts_ = starts_ || autoplay;
    if (!player_) {
        player_ = Object::construct("AudioStreamPlayer");
        player_.call("set_stream", stream);
        object().call("add_child", player_, false, 1);  // INTERNAL_MODE_FRONT
    }
    if (RoomNode::of(object()) == nullptr)
        log_error("AulaSource3D " + object().call("get_path").to_string() +
                  ": no AulaRoom is above it or in the tree");
    join();
}

void SourceNode::join() {
    if (room_ != nullptr || !player_) return;
    room_ = RoomNode::of(object());
    if (room_ == nullptr) return;
    pose_error_.clear();
    gain_error_.clear();
    bus_ =
        std::make_unique<Bus>("AulaSource " + std::to_string(object().id()), input_, room_->bus());
    player_.call("set_bus", bus_->name());
    if (!room_->add(*this)) leave();
}

void SourceNode::leave() {
    starts_ = is_playing();
    player_.call("stop");
    bus_.reset();
    input_->number = 0;
    room_ = nullptr;
}

std::string SourceNode::name() const {
    return room_->object().call("get_path_to", object()).to_string();
}

aula_pose SourceNode::pose(const Transform& frame) const {
    return pose_of(relative(rigid(global_transform(object())), frame));
}

aula_source SourceNode::add_to(aula_scene* scene, const aula_pose& pose) const {
    aula_source number = 0;
    require(aula_scene_add_source(scene, name().c_str(), &pose, directivity.c_str(),
                                  static_cast<float>(gain_db), &number));
    return number;
}

aula_source SourceNode::add_to(aula_room* room, const aula_pose& pose) const {
    aula_source number = 0;
    require(aula_room_add_source(room, &pose, directivity.c_str(), AULA_NOW, &number));
    if (aula_room_set_gain(room, number, static_cast<float>(gain_db), AULA_NOW) != AULA_OK) {
        const std::string problem = aula_message();
        aula_room_remove_source(room, number, AULA_NOW);
        throw RoomError{problem};
    }
    return number;
}

void SourceNode::start(const aula_pose& pose, const std::string& heard_directivity) {
    pose_ = pose;
    heard_directivity_ = heard_directivity;
    if (!starts_) return;
    starts_ = false;
    player_.call("play");
}

void SourceNode::move(aula_room* room, const Transform& frame) {
    if (input_->number == 0) return;
    const aula_pose newest = pose(frame);
    if (std::memcmp(&newest, &pose_, sizeof newest) == 0) return;
    pose_ = newest;
    room_->check(aula_room_set_source(room, input_->number, &newest, AULA_NOW), object(),
                 pose_error_);
}

SavedSource SourceNode::saved(const Transform& frame) const {
    SavedSource source;
    source.name = name();
    source.directivity = directivity;
    source.pose = pose(frame);
    source.gain_db = gain_db;
    if (const Object resource = stream.to_object()) {
        const std::string path = resource.call("get_path").to_string();
        if (!path.empty())
            source.signal =
                Object::singleton("ProjectSettings").call("globalize_path", path).to_string();
        source.loop = resource.call("get", "loop_mode").type() == GDEXTENSION_VARIANT_TYPE_INT
                          ? resource.call("get", "loop_mode").to_int() != 0
                          : resource.call("get", "loop").to_bool();
    }
    return source;
}

void SourceNode::play() {
    if (input_->number != 0)
        player_.call("play");
    else
        starts_ = true;
}

void SourceNode::stop() {
    starts_ = false;
    if (player_) player_.call("stop");
}

bool SourceNode::is_playing() const {
    return starts_ || (player_ && player_.call("is_playing").to_bool());
}

void SourceNode::set_stream(const Value& value) {
    stream = value;
    if (player_) player_.call("set_stream", stream);
}

void SourceNode::set_gain_db(double value) {
    gain_db = value;
    if (input_->number == 0) return;
    room_->check(
        aula_room_set_gain(room_->room(), input_->number, static_cast<float>(gain_db), AULA_NOW),
        object(), gain_error_);
}

std::unique_ptr<ClassEntry> register_source() {
    using Node = SourceNode;
    auto entry = std::make_unique<ClassEntry>(
        "AulaSource3D", "Node3D", [](Object object) -> Instance* { return new SourceNode(object); },
        true, true);
    entry->add_property(
        {.name = "stream",
         .type = GDEXTENSION_VARIANT_TYPE_OBJECT,
         .class_name = "AudioStream",
         .hint = 17,  // PROPERTY_HINT_RESOURCE_TYPE
         .hint_string = "AudioStream"},
        method_of<Node>([](Node& self, const Value*) { return self.stream; }),
        method_of<Node>([](Node& self, const Value* a) { return self.set_stream(a[0]), Value(); }));
    entry->add_property(
        {.name = "gain_db",
         .type = GDEXTENSION_VARIANT_TYPE_FLOAT,
         .hint = 1,  // PROPERTY_HINT_RANGE
         .hint_string = "-80,40,0.1,suffix:dB"},
        method_of<Node>([](Node& self, const Value*) { return Value(self.gain_db); }),
        method_of<Node>([](Node& self, const Value* a) {
            return self.set_gain_db(a[0].to_double()), Value();
        }));
    entry->add_property(
        {.name = "directivity",
         .type = GDEXTENSION_VARIANT_TYPE_STRING,
         .hint = 2,  // PROPERTY_HINT_ENUM
         .hint_string = "omni,subcardioid,cardioid,supercardioid,figure_of_eight,talker,"
                        "loudspeaker"},
        method_of<Node>([](Node& self, const Value*) { return Value(self.directivity); }),
        method_of<Node>([](Node& self, const Value* a) {
            return self.directivity = a[0].to_string(), Value();
        }));
    entry->add_property(
        {.name = "autoplay", .type = GDEXTENSION_VARIANT_TYPE_BOOL},
        method_of<Node>([](Node& self, const Value*) { return Value(self.autoplay); }),
        method_of<Node>(
            [](Node& self, const Value* a) { return self.autoplay = a[0].to_bool(), Value(); }));
    entry->add_method(
        "play", method_of<Node>([](Node& self, const Value*) { return self.play(), Value(); }));
    entry->add_method(
        "stop", method_of<Node>([](Node& self, const Value*) { return self.stop(), Value(); }));
    entry->add_method("is_playing", method_of<Node>([](Node& self, const Value*) {
                          return Value(self.is_playing());
                      }),
                      {.name = "", .type = GDEXTENSION_VARIANT_TYPE_BOOL});
    entry->add_method(
        "get_player",
        method_of<Node>([](Node& self, const Value*) { return Value(self.player()); }),
        {.name = "", .type = GDEXTENSION_VARIANT_TYPE_OBJECT, .class_name = "AudioStreamPlayer"});
    return entry;
}

}  // namespace aula::godot
