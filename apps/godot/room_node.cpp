#include "apps/godot/room_node.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

#include "apps/godot/listener_node.h"
#include "apps/godot/notifications.h"
#include "apps/godot/source_node.h"

namespace aula::godot {
namespace {

constexpr const char* kGroup = "aula_rooms";

/// Samples that the engine mixes at a time.
constexpr int kBlock = 512;

/// A room has places for a multiple of so many sources: the default of the library.
constexpr std::size_t kPlaces = 16;

std::size_t places_for(std::size_t sources) {
    return std::max((sources + kPlaces - 1) / kPlaces, std::size_t{1}) * kPlaces;
}

bool is_ready(const std::future<RoomHandle>& room) {
    return room.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

/// What threads still do for nodes that are gone: a future waits when it is destroyed.
std::vector<std::future<RoomHandle>>& abandoned() {
    static std::vector<std::future<RoomHandle>> rooms;
    return rooms;
}

double mix_rate_hz() { return Object::singleton("AudioServer").call("get_mix_rate").to_double(); }

/// Whether the engine writes a film: it renders as slowly as it must, all on one thread.
bool writes_film() { return Object::singleton("OS").call("has_feature", "movie").to_bool(); }

}  // namespace

RoomNode::~RoomNode() { exit(); }

RoomNode* RoomNode::of(Object node) {
    for (Object above = node; above; above = above.call("get_parent").to_object())
        if (auto* room = instance_of<RoomNode>(above)) return room;
    const Object tree = node.call("get_tree").to_object();
    return instance_of<RoomNode>(tree.call("get_first_node_in_group", kGroup).to_object());
}

void RoomNode::notified(int notification) {
    if (notification == kEnterTree)
        enter();
    else if (notification == kExitTree)
        exit();
    else if (notification == kPostEnterTree)
        gather();
    else if (notification == kInternalProcess)
        update();
}

void RoomNode::wait_for_abandoned() { abandoned().clear(); }

void RoomNode::enter() {
    object().call("add_to_group", kGroup);
    says_no_listener_ = false;
    head_error_.clear();
    output_ = std::make_shared<RoomOutput>(mix_rate_hz());
    bus_ = std::make_unique<Bus>("AulaRoom " + std::to_string(object().id()), output_, "Master");
    object().call("set_process_internal", true);
    add_monitors();
}

void RoomNode::exit() {
    if (output_ == nullptr) return;
    remove_monitors();
    {
        const AudioLock lock;
        output_->exchange(nullptr, false);
    }
    bus_.reset();
    output_.reset();
    if (making_) abandoned().push_back(std::move(making_->room));
    making_.reset();
    is_outdated_ = false;
    moving_.clear();
    room_.reset();
    // What is not below the room remains in the tree.
    object().call("remove_from_group", kGroup);
    for (SourceNode* source : std::exchange(sources_, {})) {
        source->leave();
        source->join();
    }
    for (ListenerNode* listener : std::exchange(listeners_, {})) {
        listener->leave();
        listener->join();
    }
}

void RoomNode::gather() {
    const Value parts = object().call("get_tree").call("get_nodes_in_group", kRoomPartsGroup);
    const std::int64_t count = parts.size();
    for (std::int64_t i = 0; i < count; ++i) {
        const Object part = parts.element(i).to_object();
        if (auto* source = instance_of<SourceNode>(part)) source->join();
        if (auto* listener = instance_of<ListenerNode>(part)) listener->join();
    }
    object().call("call_deferred", "rebuild");  // after CSG shapes have their meshes
}

bool RoomNode::suits() const {
    // A scene without sources is not prepared for any.
    return (had_sources_ || sources_.empty()) &&
           sources_.size() <= static_cast<std::size_t>(options_.max_sources);
}

bool RoomNode::add(SourceNode& source) {
    bool has_place = false;
    {
        const AudioLock lock;
        has_place = output_->add(source.input());
    }
    if (!has_place) {
        write_error(source, "the room has " + std::to_string(RoomOutput::kMostInputs) +
                                " sources, the most");
        return false;
    }
    sources_.push_back(&source);
    if (room_ != nullptr && writes_film()) rebuild();  // its room has no place for more
    if (room_ == nullptr || writes_film()) return true;
    if (!suits()) {
        is_outdated_ = is_outdated_ || !making_;
        return true;
    }
    admit(source);
    return true;
}

void RoomNode::admit(SourceNode& source) {
    if (status().sources == options_.max_sources) return;
    try {
        const aula_pose pose = source.pose(rigid(global_transform(object())));
        const aula_source number = source.add_to(room_.get(), pose);
        {
            const AudioLock lock;
            source.input().number = number;
        }
        source.start(pose, source.directivity);
    } catch (const RoomError& error) {
        write_error(source, error.message);
    }
}

void RoomNode::remove(SourceNode& source) {
    std::erase(sources_, &source);
    if (making_)
        for (SourceInMaking& known : making_->sources)
            if (known.node == &source) known.node = nullptr;
    const aula_source number = source.input().number;
    {
        const AudioLock lock;
        output_->remove(source.input());
        source.input().number = 0;
    }
    if (room_ != nullptr && number != 0) aula_room_remove_source(room_.get(), number, AULA_NOW);
}

void RoomNode::add(ListenerNode& listener) {
    listeners_.push_back(&listener);
    choose_bus();
}

void RoomNode::remove(const ListenerNode& listener) {
    std::erase(listeners_, &listener);
    choose_bus();
}

void RoomNode::choose_bus() {
    if (!listeners_.empty()) bus_->send_to(listeners_.back()->bus());
}

void RoomNode::rebuild() {
    if (output_ == nullptr) return;
    is_outdated_ = making_.has_value();
    if (is_outdated_) return;
    try {
        begin();
        if (writes_film()) finish();
    } catch (const RoomError& error) {
        write_error(error.message);
    }
}

aula_options RoomNode::options() const {
    aula_options options{};
    options.size = sizeof options;
    options.sample_rate_hz = mix_rate_hz();
    options.ir_length_s = ir_length_s;
    options.clock = writes_film() ? AULA_EXACT : AULA_REAL_TIME;
    options.block = kBlock;
    // In a film as many as there are: the samples are then those of aula --offline.
    options.max_sources = static_cast<std::int32_t>(
        writes_film() ? std::max(sources_.size(), std::size_t{1}) : places_for(sources_.size()));
    options.rays = rays;
    return options;
}

bool RoomNode::can_exchange(const aula_options& wanted) const {
    // A room whose propagation has failed has no status.
    return status().channels > 0 && wanted.sample_rate_hz == options_.sample_rate_hz &&
           wanted.rays == options_.rays && wanted.ir_length_s == options_.ir_length_s &&
           wanted.max_sources <= options_.max_sources &&
           std::none_of(sources_.begin(), sources_.end(),
                        [](const SourceNode* source) { return source->has_new_directivity(); });
}

void RoomNode::begin() {
    RoomInMaking made;
    made.options = options();
    const Transform frame = rigid(global_transform(object()));
    SceneHandle scene = make_scene(collect_geometry(object(), material()), frame, made.moving);
    for (SourceNode* source : sources_) {
        made.sources.push_back({source, 0, source->pose(frame), source->directivity});
        try {
            made.sources.back().number = source->add_to(scene.get(), made.sources.back().pose);
        } catch (const RoomError& error) {
            write_error(*source, error.message);
        }
    }
    made.head = listener_pose(frame);
    require(aula_scene_set_listener(scene.get(), &made.head));
    made.room =
        std::async(std::launch::async, [scene = std::move(scene), options = made.options,
                                        present = can_exchange(made.options) ? room_ : nullptr] {
            if (present != nullptr) {
                require(aula_room_set_scene(present.get(), scene.get(), AULA_NOW));
                return present;
            }
            aula_room* room = nullptr;
            require(aula_room_create(scene.get(), &options, &room));
            return RoomHandle(room, aula_room_destroy);
        });
    making_ = std::move(made);
}

void RoomNode::finish() {
    RoomInMaking made = std::move(*making_);
    making_.reset();
    RoomHandle room = made.room.get();
    had_sources_ = !made.sources.empty();
    moving_ = std::move(made.moving);
    if (room != room_)
        play(std::move(room), made);
    else  // motions of objects of the scene before may have moved those of this one
        for (MovingObject& moving : moving_) moving.motion = {};
    for (SourceNode* source : sources_) {
        const bool has_failed = std::any_of(
            made.sources.begin(), made.sources.end(),
            [&](const SourceInMaking& known) { return known.node == source && known.number == 0; });
        if (source->input().number == 0 && !has_failed) admit(*source);
    }
    is_outdated_ = is_outdated_ || !suits();
}

void RoomNode::play(RoomHandle room, const RoomInMaking& made) {
    {
        const AudioLock lock;
        output_->exchange(room.get(), writes_film());
        for (SourceNode* source : sources_) source->input().number = 0;
        for (const SourceInMaking& known : made.sources)
            if (known.node != nullptr) known.node->input().number = known.number;
    }
    room_ = std::move(room);
    options_ = made.options;
    head_ = made.head;
    for (const SourceInMaking& known : made.sources) {
        if (known.number == 0) continue;
        if (known.node == nullptr) {  // gone meanwhile
            aula_room_remove_source(room_.get(), known.number, AULA_NOW);
            continue;
        }
        known.node->set_gain_db(known.node->gain_db);
        known.node->start(known.pose, known.directivity);
    }
}

bool RoomNode::save(const std::string& file) {
    try {
        const Transform frame = rigid(global_transform(object()));
        std::vector<SavedSource> sources;
        for (const SourceNode* source : sources_) sources.push_back(source->saved(frame));
        save_scene(Object::singleton("ProjectSettings").call("globalize_path", file).to_string(),
                   collect_geometry(object(), material()), sources, listener_pose(frame), rays,
                   ir_length_s);
        return true;
    } catch (const RoomError& error) {
        write_error(error.message);
        return false;
    }
}

aula_pose RoomNode::listener_pose(const Transform& frame) const {
    if (listeners_.empty()) return {};
    return pose_of(relative(rigid(global_transform(listeners_.back()->object())), frame));
}

void RoomNode::move_listener(const Transform& frame) {
    const aula_pose head = listener_pose(frame);
    if (std::memcmp(&head, &head_, sizeof head) == 0) return;
    head_ = head;
    check(aula_room_set_listener(room_.get(), 0, &head, AULA_NOW),
          listeners_.empty() ? object() : listeners_.back()->object(), head_error_);
}

void RoomNode::move_bodies(const Transform& frame) {
    for (MovingObject& moving : moving_) {
        const Object body = Object::of_id(moving.body);
        if (!body || !body.call("is_inside_tree").to_bool()) continue;
        const auto newest = motion(moving.at_rest, relative(rigid(global_transform(body)), frame));
        if (newest == moving.motion) continue;
        moving.motion = newest;
        const int result =
            aula_room_set_transform(room_.get(), moving.object, newest.data(), AULA_NOW);
        // The scene may just have been exchanged, with other objects.
        if (!making_) check(result, body, moving.error);
    }
}

void RoomNode::update() {
    std::erase_if(abandoned(), is_ready);
    if (making_ && is_ready(making_->room)) {
        try {
            finish();
        } catch (const RoomError& error) {
            write_error(error.message);
        }
    }
    if (is_outdated_ && !making_) rebuild();
    if (listeners_.empty() && !says_no_listener_) write_error("no AulaListener3D hears the room");
    says_no_listener_ = listeners_.empty();
    if (room_ == nullptr) return;
    const Transform frame = rigid(global_transform(object()));
    move_listener(frame);
    for (SourceNode* source : sources_) source->move(room_.get(), frame);
    move_bodies(frame);
}

aula_status RoomNode::status() const {
    aula_status status{};
    status.size = sizeof status;
    if (room_ != nullptr) aula_room_status(room_.get(), &status);
    return status;
}

void RoomNode::check(int result, Object node, std::string& last_error) {
    const std::string message = result == AULA_OK ? "" : aula_message();
    if (message == last_error) return;
    last_error = message;
    if (!message.empty())
        write_error(object().call("get_path_to", node).to_string() + ": " + message);
}

void RoomNode::write_error(const std::string& message) const {
    log_error("AulaRoom " + object().call("get_path").to_string() + ": " + message);
}

void RoomNode::write_error(const SourceNode& source, const std::string& message) const {
    write_error(object().call("get_path_to", source.object()).to_string() + ": " + message);
}

}  // namespace aula::godot
