#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "apps/godot/bind/api.h"

namespace aula::godot {

class Value;

/// A name of the engine, compared by its address. [main thread]
class StringName {
 public:
    explicit StringName(const char* text);
    StringName(const StringName&) = delete;
    StringName& operator=(const StringName&) = delete;
    ~StringName();

    void* pointer() { return &data_; }
    const void* pointer() const { return &data_; }
    /// Whether the engine's name is the same.
    bool is(GDExtensionConstStringNamePtr other) const {
        return *static_cast<void* const*>(other) == data_;
    }

 private:
    void* data_ = nullptr;
};

/// An object of the engine, not owned.
struct Object {
    GDExtensionObjectPtr pointer = nullptr;

    explicit operator bool() const { return pointer != nullptr; }
    bool operator==(const Object&) const = default;
    /// For a later of_id(). The object may be gone by then.
    std::uint64_t id() const { return api.object_get_instance_id(pointer); }
    static Object of_id(std::uint64_t id) { return {api.object_get_instance_from_id(id)}; }
    static Object singleton(const char* name);
    /// Constructs an object of a class of the engine. Who receives it owns it.
    static Object construct(const char* class_name);
    /// What follows the construction by classdb_construct_object2.
    void finish_construction() const;
    bool is_class(const char* name) const;

    template <class... Arguments>
    Value call(const char* method, const Arguments&... arguments) const;
};

/// A value of any type of the engine (Variant). [main thread]
class Value {
 public:
    Value() { api.variant_new_nil(data_.data()); }
    Value(bool value);
    Value(int value) : Value(std::int64_t{value}) {}
    Value(std::int64_t value);
    Value(double value);
    Value(const char* text);
    Value(const std::string& text) : Value(text.c_str()) {}
    Value(Object object);
    Value(const Value& other) { api.variant_new_copy(data_.data(), other.data_.data()); }
    Value& operator=(const Value& other);
    ~Value() { api.variant_destroy(data_.data()); }

    static Value copy(GDExtensionConstVariantPtr variant);
    /// Of a value of a built-in type.
    static Value of_type(GDExtensionVariantType type, const void* value);
    /// Callable of a method.
    static Value callable(Object object, const char* method);

    GDExtensionVariantType type() const { return api.variant_get_type(data_.data()); }
    bool to_bool() const { return to<GDExtensionBool>(GDEXTENSION_VARIANT_TYPE_BOOL) != 0; }
    std::int64_t to_int() const { return to<std::int64_t>(GDEXTENSION_VARIANT_TYPE_INT); }
    double to_double() const { return to<double>(GDEXTENSION_VARIANT_TYPE_FLOAT); }
    std::string to_string() const;
    /// Null for other types.
    Object to_object() const;
    /// Of a type without a destructor.
    template <class T>
    T to(GDExtensionVariantType type) const {
        T value{};
        api.get_variant_to_type_constructor(type)(&value, pointer());
        return value;
    }
    /// Elements of a packed array of numbers or of vectors; empty for other types.
    std::vector<float> to_floats() const;
    std::vector<std::int32_t> to_integers() const;
    std::vector<std::array<float, 3>> to_vectors() const;
    /// An element of an array; nil beyond its end.
    Value element(std::int64_t index) const;

    /// Calls a method. An unsuitable call is an error in the log, and returns nil.
    template <class... Arguments>
    Value call(const char* method, const Arguments&... arguments) const {
        const std::array<Value, sizeof...(Arguments)> values{Value(arguments)...};
        return call_with(method, values.data(), values.size());
    }
    std::int64_t size() const { return call("size").to_int(); }

    GDExtensionConstVariantPtr data() const { return data_.data(); }

 private:
    /// Bytes of a Variant in engines of single precision.
    static constexpr std::size_t kBytes = 24;

    Value call_with(const char* method, const Value* arguments, std::size_t count) const;
    /// What the engine calls writable, but only reads.
    GDExtensionVariantPtr pointer() const { return const_cast<unsigned char*>(data_.data()); }
    const void* internal() const;

    alignas(8) std::array<unsigned char, kBytes> data_;
};

template <class... Arguments>
Value Object::call(const char* method, const Arguments&... arguments) const {
    return Value(*this).call(method, arguments...);
}

}  // namespace aula::godot
