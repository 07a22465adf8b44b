#pragma once

#include "apps/godot/bind/value.h"

namespace aula::godot {

/// What the extension adds to an object of one of its classes. The engine destroys it with the
/// object. [main thread, unless stated otherwise]
class Instance {
 public:
    explicit Instance(Object object) : object_(object) {}
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;
    virtual ~Instance() = default;

    Object object() const { return object_; }
    /// A notification of the engine (the constants NOTIFICATION_...).
    virtual void notified(int /*notification*/) {}

    /// The instance of an object of this extension's; null for other objects.
    static Instance* of(Object object) {
        if (!object) return nullptr;
        return static_cast<Instance*>(
            api.object_get_instance_binding(object.pointer, api.library, nullptr));
    }

 private:
    Object object_;
};

/// The instance of an object, if it is a T.
template <class T>
T* instance_of(Object object) {
    return dynamic_cast<T*>(Instance::of(object));
}

}  // namespace aula::godot
