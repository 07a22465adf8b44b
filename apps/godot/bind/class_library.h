#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/godot/bind/instance.h"

namespace aula::godot {

/// A named value of a class: an argument, a result or a property.
struct ValueInfo {
    std::string name;
    GDExtensionVariantType type = GDEXTENSION_VARIANT_TYPE_NIL;
    std::string class_name = {};  ///< of objects
    std::uint32_t hint = 0;       ///< PROPERTY_HINT_...
    std::string hint_string = {};
    std::uint32_t usage = 6;  ///< PROPERTY_USAGE_...; 6: stored, and shown by the inspector
};

/// How an instance answers a call.
using Method = std::function<Value(Instance&, const Value*)>;

/// A class of the extension, while the engine knows it.
class ClassEntry {
 public:
    using Factory = Instance* (*)(Object);

    /// Registers a class. A `is_runtime` class does nothing in the editor but show its properties.
    /// A class that is not `is_exposed` is for the extension alone.
    ClassEntry(const char* name, const char* parent, Factory factory, bool is_runtime,
               bool is_exposed);
    ClassEntry(const ClassEntry&) = delete;
    ClassEntry& operator=(const ClassEntry&) = delete;
    ~ClassEntry();

    /// Adds a method. `result`: NIL for none.
    void add_method(const char* name, Method method, ValueInfo result = {},
                    std::vector<ValueInfo> arguments = {});
    /// Adds a property with the methods get_NAME and set_NAME; without `set` it is only read.
    void add_property(ValueInfo info, Method get, Method set);
    /// Adds a virtual function of the parent.
    void add_virtual(const char* name, GDExtensionClassCallVirtual function);

 private:
    struct BoundMethod {
        Method method;
        ValueInfo result;
        std::vector<ValueInfo> arguments;
    };

    static GDExtensionObjectPtr create(void* entry, GDExtensionBool notify);
    static GDExtensionClassCallVirtual find_virtual(void* entry, GDExtensionConstStringNamePtr name,
                                                    std::uint32_t hash);
    static void call(void* method, void* instance, const GDExtensionConstVariantPtr* arguments,
                     GDExtensionInt count, GDExtensionVariantPtr result,
                     GDExtensionCallError* error);
    static void call_by_pointers(void* method, void* instance,
                                 const GDExtensionConstTypePtr* arguments, void* result);

    StringName name_, parent_;
    Factory factory_;
    std::vector<std::unique_ptr<BoundMethod>> methods_;
    std::vector<std::pair<std::unique_ptr<StringName>, GDExtensionClassCallVirtual>> virtuals_;
};

/// Makes a Method of a function of T.
template <class T, class Function>
Method method_of(Function function) {
    return [function](Instance& instance, const Value* arguments) -> Value {
        return function(static_cast<T&>(instance), arguments);
    };
}

}  // namespace aula::godot
