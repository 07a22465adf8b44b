#pragma once

#include <memory>
#include <string>

#include "apps/godot/bind/class_library.h"
#include "apps/godot/sound/bus_processor.h"

namespace aula::godot {

/// A bus at the end of the engine's list with an effect that is a BusProcessor. The engine
/// processes later buses first. [main thread]
class Bus {
 public:
    Bus(std::string name, std::shared_ptr<BusProcessor> processor, const std::string& send);
    Bus(const Bus&) = delete;
    Bus& operator=(const Bus&) = delete;
    /// Removes the bus, unless it has been removed.
    ~Bus();

    const std::string& name() const { return name_; }
    void send_to(const std::string& bus);

 private:
    std::string name_;
};

/// Holds the engine's audio lock: no bus is processed meanwhile. [main thread]
class AudioLock {
 public:
    AudioLock();
    AudioLock(const AudioLock&) = delete;
    AudioLock& operator=(const AudioLock&) = delete;
    ~AudioLock();
};

/// Registers the class of the effect and that of its instances on the channels of a bus.
std::unique_ptr<ClassEntry> register_bus_effect();
std::unique_ptr<ClassEntry> register_bus_effect_instance();

}  // namespace aula::godot
