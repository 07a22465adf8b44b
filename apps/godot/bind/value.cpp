#include "apps/godot/bind/value.h"

#include <cstddef>

namespace aula::godot {
namespace {

/// A text of the engine.
class String {
 public:
    String() = default;
    explicit String(const char* text) { api.string_new_with_utf8_chars(&data_, text); }
    String(const String&) = delete;
    String& operator=(const String&) = delete;
    ~String() { api.variant_get_ptr_destructor(GDEXTENSION_VARIANT_TYPE_STRING)(&data_); }
    void* pointer() { return &data_; }

 private:
    void* data_ = nullptr;
};

template <class Source, class Function>
auto elements(const Value& value, const void* array, Function at) {
    std::vector<Source> result;
    const std::int64_t size = value.size();
    if (size == 0) return result;
    const auto* first = reinterpret_cast<const Source*>(at(array, 0));
    result.assign(first, first + size);
    return result;
}

}  // namespace

StringName::StringName(const char* text) { api.string_name_new_with_utf8_chars(&data_, text); }

StringName::~StringName() {
    api.variant_get_ptr_destructor(GDEXTENSION_VARIANT_TYPE_STRING_NAME)(&data_);
}

Object Object::singleton(const char* name) {
    return {api.global_get_singleton(StringName(name).pointer())};
}

Object Object::construct(const char* class_name) {
    const Object object{api.classdb_construct_object2(StringName(class_name).pointer())};
    object.finish_construction();
    return object;
}

void Object::finish_construction() const {
    // Not call(): its reference would be the last of an object that counts them.
    constexpr std::int64_t kPostInitialize = 0, kHash = 4023243586;
    const std::int64_t what = kPostInitialize;
    const GDExtensionBool reversed = 0;
    const std::array<GDExtensionConstTypePtr, 2> arguments{&what, &reversed};
    static const GDExtensionMethodBindPtr kNotification = api.classdb_get_method_bind(
        StringName("Object").pointer(), StringName("notification").pointer(), kHash);
    api.object_method_bind_ptrcall(kNotification, pointer, arguments.data(), nullptr);
}

bool Object::is_class(const char* name) const { return call("is_class", name).to_bool(); }

Value::Value(bool value) {
    GDExtensionBool stored = value ? 1 : 0;
    api.get_variant_from_type_constructor(GDEXTENSION_VARIANT_TYPE_BOOL)(data_.data(), &stored);
}

Value::Value(std::int64_t value) {
    api.get_variant_from_type_constructor(GDEXTENSION_VARIANT_TYPE_INT)(data_.data(), &value);
}

Value::Value(double value) {
    api.get_variant_from_type_constructor(GDEXTENSION_VARIANT_TYPE_FLOAT)(data_.data(), &value);
}

Value::Value(const char* text) {
    String string(text);
    api.get_variant_from_type_constructor(GDEXTENSION_VARIANT_TYPE_STRING)(data_.data(),
                                                                           string.pointer());
}

Value::Value(Object object) {
    api.get_variant_from_type_constructor(GDEXTENSION_VARIANT_TYPE_OBJECT)(data_.data(),
                                                                           &object.pointer);
}

Value& Value::operator=(const Value& other) {
    if (this == &other) return *this;
    api.variant_destroy(data_.data());
    api.variant_new_copy(data_.data(), other.data_.data());
    return *this;
}

Value Value::copy(GDExtensionConstVariantPtr variant) {
    Value value;
    api.variant_new_copy(value.data_.data(), variant);
    return value;
}

Value Value::of_type(GDExtensionVariantType type, const void* source) {
    Value value;
    if (type != GDEXTENSION_VARIANT_TYPE_NIL)
        api.get_variant_from_type_constructor(type)(value.data_.data(), const_cast<void*>(source));
    return value;
}

Value Value::callable(Object object, const char* method) {
    Value value;
    StringName name(method);
    const Value target(object),
        target_method = of_type(GDEXTENSION_VARIANT_TYPE_STRING_NAME, name.pointer());
    const std::array<GDExtensionConstVariantPtr, 2> arguments{target.data(), target_method.data()};
    GDExtensionCallError error{};
    api.variant_construct(GDEXTENSION_VARIANT_TYPE_CALLABLE, value.data_.data(), arguments.data(),
                          2, &error);
    return value;
}

std::string Value::to_string() const {
    String string;
    api.variant_stringify(data_.data(), string.pointer());
    const GDExtensionInt length = api.string_to_utf8_chars(string.pointer(), nullptr, 0);
    std::string text(static_cast<std::size_t>(length), '\0');
    api.string_to_utf8_chars(string.pointer(), text.data(), length);
    return text;
}

Object Value::to_object() const {
    if (type() != GDEXTENSION_VARIANT_TYPE_OBJECT) return {};
    return {to<GDExtensionObjectPtr>(GDEXTENSION_VARIANT_TYPE_OBJECT)};
}

std::vector<float> Value::to_floats() const {
    if (type() != GDEXTENSION_VARIANT_TYPE_PACKED_FLOAT32_ARRAY) return {};
    return elements<float>(*this, internal(), api.packed_float32_array_operator_index_const);
}

std::vector<std::int32_t> Value::to_integers() const {
    if (type() != GDEXTENSION_VARIANT_TYPE_PACKED_INT32_ARRAY) return {};
    return elements<std::int32_t>(*this, internal(), api.packed_int32_array_operator_index_const);
}

std::vector<std::array<float, 3>> Value::to_vectors() const {
    if (type() != GDEXTENSION_VARIANT_TYPE_PACKED_VECTOR3_ARRAY) return {};
    return elements<std::array<float, 3>>(*this, internal(),
                                          api.packed_vector3_array_operator_index_const);
}

Value Value::element(std::int64_t index) const {
    Value value;
    GDExtensionBool is_valid = 0, is_outside = 0;
    api.variant_get_indexed(data_.data(), index, value.data_.data(), &is_valid, &is_outside);
    return value;
}

Value Value::call_with(const char* method, const Value* arguments, std::size_t count) const {
    std::array<GDExtensionConstVariantPtr, 8> pointers{};
    for (std::size_t i = 0; i < count; ++i) pointers[i] = arguments[i].data();
    Value result;
    GDExtensionCallError error{};
    api.variant_call(pointer(), StringName(method).pointer(), pointers.data(),
                     static_cast<GDExtensionInt>(count), result.data_.data(), &error);
    if (error.error != GDEXTENSION_CALL_OK)
        log_error(std::string("Aula: Godot has no method ") + method + " of these arguments");
    return result;
}

const void* Value::internal() const {
    return api.variant_get_ptr_internal_getter(type())(pointer());
}

}  // namespace aula::godot
