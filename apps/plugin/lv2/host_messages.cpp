#include "apps/plugin/lv2/host_messages.h"

#include <lv2/atom/util.h>
#include <lv2/patch/patch.h>
#include <lv2/time/time.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <system_error>

#include "apps/plugin/lv2/features.h"
#include "apps/plugin/lv2/ports.h"

namespace aula::plugin {

namespace {

constexpr const char* kSeedUri = AULA_PLUGIN_URI "#seed";
constexpr const char* kKeysUri = AULA_PLUGIN_URI "#keys";

std::string_view text_of(const LV2_Atom& atom) {
    const auto* const text = static_cast<const char*>(LV2_ATOM_BODY_CONST(&atom));
    return {text, strnlen(text, atom.size)};
}

/// A path that a host has allocated.
class HostPath {
 public:
    HostPath(char* path, const LV2_State_Free_Path* free_path)
        : path_(path), free_path_(free_path) {}
    ~HostPath() {
        if (free_path_ != nullptr)
            free_path_->free_path(free_path_->handle, path_);
        else
            std::free(path_);
    }
    HostPath(const HostPath&) = delete;
    HostPath& operator=(const HostPath&) = delete;

    std::string text() const { return path_ != nullptr ? path_ : ""; }

 private:
    char* path_;
    const LV2_State_Free_Path* free_path_;
};

/// The file that a link of a host's session refers to: the other files of a scene are relative to
/// it. The path itself if there is no file.
std::filesystem::path resolved(const std::filesystem::path& file) {
    if (file.empty()) return file;
    std::error_code error;
    const std::filesystem::path real = std::filesystem::canonical(file, error);
    return error ? file : real;
}

}  // namespace

HostMessages::HostMessages(const LV2_URID_Map* map) : mapped_(map != nullptr) {
    if (!mapped_) return;
    map_ = *map;
    const auto urid = [&](const char* uri) { return map->map(map->handle, uri); };
    urids_ = {.path = urid(LV2_ATOM__Path),
              .string = urid(LV2_ATOM__String),
              .urid = urid(LV2_ATOM__URID),
              .object = urid(LV2_ATOM__Object),
              .blank = urid(LV2_ATOM__Blank),
              .integer = urid(LV2_ATOM__Int),
              .whole = urid(LV2_ATOM__Long),
              .single = urid(LV2_ATOM__Float),
              .real = urid(LV2_ATOM__Double),
              .set = urid(LV2_PATCH__Set),
              .get = urid(LV2_PATCH__Get),
              .property = urid(LV2_PATCH__property),
              .value = urid(LV2_PATCH__value),
              .position = urid(LV2_TIME__Position),
              .frame = urid(LV2_TIME__frame),
              .speed = urid(LV2_TIME__speed),
              .seed = urid(kSeedUri),
              .keys = urid(kKeysUri),
              .properties = {}};
    for (std::size_t p = 0; p < kProperties; ++p) urids_.properties[p] = urid(kPropertyUris[p]);
    LV2_URID_Map copy = *map;
    lv2_atom_forge_init(&forge_, &copy);
}

void HostMessages::begin(const LV2_Atom_Sequence* control, LV2_Atom_Sequence* notify) noexcept {
    control_ = mapped_ ? control : nullptr;
    next_ = control_ != nullptr ? lv2_atom_sequence_begin(&control_->body) : nullptr;
    writes_ = mapped_ && notify != nullptr;
    if (!writes_) return;
    const std::uint32_t capacity = notify->atom.size;
    lv2_atom_forge_set_buffer(&forge_, reinterpret_cast<std::uint8_t*>(notify), capacity);
    lv2_atom_forge_sequence_head(&forge_, &sequence_, 0);
}

std::optional<HostEvent> HostMessages::next() noexcept {
    while (control_ != nullptr &&
           !lv2_atom_sequence_is_end(&control_->body, control_->atom.size, next_)) {
        const LV2_Atom_Event& event = *next_;
        next_ = lv2_atom_sequence_next(next_);
        if (auto understood = event_of(event)) return understood;
    }
    return std::nullopt;
}

std::optional<HostEvent> HostMessages::event_of(const LV2_Atom_Event& event) const noexcept {
    if (event.body.type != urids_.object && event.body.type != urids_.blank) return std::nullopt;
    const auto& object = reinterpret_cast<const LV2_Atom_Object&>(event.body);
    std::optional<HostEvent> understood;
    if (object.body.otype == urids_.set) {
        understood = set_event(object);
    } else if (object.body.otype == urids_.get) {
        understood = HostEvent{.kind = HostEvent::Kind::get};
    } else if (object.body.otype == urids_.position) {
        const LV2_Atom* frame = nullptr;
        const LV2_Atom* speed = nullptr;
        lv2_atom_object_get(&object, urids_.frame, &frame, urids_.speed, &speed, 0);
        understood = HostEvent{.kind = HostEvent::Kind::position,
                               .frame = static_cast<std::int64_t>(number(frame, 0)),
                               .speed = number(speed, 0)};
    }
    if (understood) understood->offset = event.time.frames;
    return understood;
}

std::optional<HostEvent> HostMessages::set_event(const LV2_Atom_Object& object) const noexcept {
    const LV2_Atom* property = nullptr;
    const LV2_Atom* value = nullptr;
    lv2_atom_object_get(&object, urids_.property, &property, urids_.value, &value, 0);
    if (property == nullptr || property->type != urids_.urid || value == nullptr) return {};
    if (value->type != urids_.path && value->type != urids_.string) return {};
    const LV2_URID name = reinterpret_cast<const LV2_Atom_URID*>(property)->body;
    for (const Property writable : {Property::scene, Property::hrtf})
        if (name == urids_.properties[static_cast<std::size_t>(writable)])
            return HostEvent{
                .kind = HostEvent::Kind::set, .property = writable, .text = text_of(*value)};
    return {};
}

double HostMessages::number(const LV2_Atom* atom, double otherwise) const noexcept {
    if (atom == nullptr) return otherwise;
    if (atom->type == urids_.whole)
        return static_cast<double>(reinterpret_cast<const LV2_Atom_Long*>(atom)->body);
    if (atom->type == urids_.integer) return reinterpret_cast<const LV2_Atom_Int*>(atom)->body;
    if (atom->type == urids_.single)
        return static_cast<double>(reinterpret_cast<const LV2_Atom_Float*>(atom)->body);
    if (atom->type == urids_.real) return reinterpret_cast<const LV2_Atom_Double*>(atom)->body;
    return otherwise;
}

bool HostMessages::send(const Message& message) noexcept {
    if (!writes_) return true;
    // An event with an object of two properties; each atom is padded to 8 bytes.
    constexpr std::uint32_t kOverhead_bytes = 128;
    if (forge_.size - forge_.offset < message.size + kOverhead_bytes) return false;
    LV2_Atom_Forge_Frame object;
    lv2_atom_forge_frame_time(&forge_, 0);
    lv2_atom_forge_object(&forge_, &object, 0, urids_.set);
    lv2_atom_forge_key(&forge_, urids_.property);
    lv2_atom_forge_urid(&forge_, urids_.properties[static_cast<std::size_t>(message.property)]);
    lv2_atom_forge_key(&forge_, urids_.value);
    const auto size = static_cast<std::uint32_t>(message.size);
    if (message.property == Property::status)
        lv2_atom_forge_string(&forge_, message.text.data(), size);
    else
        lv2_atom_forge_path(&forge_, message.text.data(), size);
    lv2_atom_forge_pop(&forge_, &object);
    return true;
}

void HostMessages::end() noexcept {
    if (writes_) lv2_atom_forge_pop(&forge_, &sequence_);
}

LV2_State_Status HostMessages::save(const StoredFiles& stored, LV2_State_Store_Function store,
                                    LV2_State_Handle handle,
                                    const LV2_Feature* const* features) const {
    if (!mapped_) return LV2_STATE_ERR_NO_FEATURE;
    const RoomFiles& files = stored.files;
    const auto* const map =
        static_cast<const LV2_State_Map_Path*>(find_feature(features, LV2_STATE__mapPath));
    const auto* const free_path =
        static_cast<const LV2_State_Free_Path*>(find_feature(features, LV2_STATE__freePath));
    constexpr std::uint32_t kPortable = LV2_STATE_IS_POD | LV2_STATE_IS_PORTABLE;
    std::string keys;  // URIs, separated by spaces
    const auto add_key = [&](const char* uri) {
        keys += (keys.empty() ? "" : " ") + std::string(uri);
    };
    const auto store_path = [&](Property property, const std::filesystem::path& file) {
        if (file.empty()) return;
        add_key(kPropertyUris[static_cast<std::size_t>(property)]);
        std::string text = file.string();
        if (map != nullptr)
            text = HostPath(map->abstract_path(map->handle, text.c_str()), free_path).text();
        store(handle, urids_.properties[static_cast<std::size_t>(property)], text.c_str(),
              text.size() + 1, urids_.path, kPortable);
    };
    store_path(Property::scene, files.scene);
    store_path(Property::hrtf, files.hrtf);
    if (files.seed) {
        const auto seed = static_cast<std::int64_t>(*files.seed);
        store(handle, urids_.seed, &seed, sizeof seed, urids_.whole, kPortable);
        add_key(kSeedUri);
    }
    for (const UnknownProperty& property : stored.unknown) {
        store(handle, map_.map(map_.handle, property.uri.c_str()), property.value.data(),
              property.value.size(), property.type, property.flags);
        add_key(property.uri.c_str());
    }
    if (!keys.empty())
        store(handle, urids_.keys, keys.c_str(), keys.size() + 1, urids_.string, kPortable);
    return LV2_STATE_SUCCESS;
}

StoredFiles HostMessages::restore(const RoomFiles& present, LV2_State_Retrieve_Function retrieve,
                                  LV2_State_Handle handle,
                                  const LV2_Feature* const* features) const {
    RoomFiles files = present;
    if (!mapped_) return {.files = files, .unknown = {}};
    const auto* const map =
        static_cast<const LV2_State_Map_Path*>(find_feature(features, LV2_STATE__mapPath));
    const auto* const free_path =
        static_cast<const LV2_State_Free_Path*>(find_feature(features, LV2_STATE__freePath));
    std::size_t size = 0;
    std::uint32_t type = 0;
    std::uint32_t flags = 0;
    const auto stored_path = [&](Property property) -> std::optional<std::filesystem::path> {
        const auto* const text = static_cast<const char*>(retrieve(
            handle, urids_.properties[static_cast<std::size_t>(property)], &size, &type, &flags));
        if (text == nullptr || type != urids_.path) return std::nullopt;
        const std::string stored(text, strnlen(text, size));
        if (map == nullptr || stored.empty()) return resolved(stored);
        return resolved(
            HostPath(map->absolute_path(map->handle, stored.c_str()), free_path).text());
    };
    // A state without a scene is one with the default room; a preset may leave out the HRTF.
    files.scene = stored_path(Property::scene).value_or(std::filesystem::path{});
    files.hrtf = stored_path(Property::hrtf).value_or(present.hrtf);
    const void* const seed = retrieve(handle, urids_.seed, &size, &type, &flags);
    files.seed.reset();
    if (seed != nullptr && type == urids_.whole && size == sizeof(std::int64_t)) {
        std::int64_t number = 0;
        std::memcpy(&number, seed, sizeof number);
        files.seed = static_cast<std::uint64_t>(number);
    }
    return {.files = files, .unknown = unknown_properties(retrieve, handle)};
}

std::vector<UnknownProperty> HostMessages::unknown_properties(LV2_State_Retrieve_Function retrieve,
                                                              LV2_State_Handle handle) const {
    std::size_t size = 0;
    std::uint32_t type = 0;
    std::uint32_t flags = 0;
    const auto* const text =
        static_cast<const char*>(retrieve(handle, urids_.keys, &size, &type, &flags));
    if (text == nullptr || type != urids_.string) return {};
    std::istringstream keys(std::string(text, strnlen(text, size)));
    std::vector<UnknownProperty> properties;
    for (std::string uri; keys >> uri;) {
        const LV2_URID key = map_.map(map_.handle, uri.c_str());
        const bool known = key == urids_.seed || key == urids_.keys ||
                           std::find(urids_.properties.begin(), urids_.properties.end(), key) !=
                               urids_.properties.end();
        if (known) continue;
        const auto* const value =
            static_cast<const char*>(retrieve(handle, key, &size, &type, &flags));
        if (value != nullptr) properties.push_back({uri, type, flags, {value, value + size}});
    }
    return properties;
}

}  // namespace aula::plugin
