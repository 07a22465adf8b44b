#include "apps/godot/bind/class_library.h"

namespace aula::godot {
namespace {

/// PROPERTY_HINT_RESOURCE_TYPE: an object that the engine counts references of.
constexpr std::uint32_t kResourceHint = 17;

/// What the engine reads of ValueInfo while it registers something.
class PropertyInfo {
 public:
    explicit PropertyInfo(const ValueInfo& value)
        : name_(value.name.c_str()),
          class_name_(value.class_name.c_str()),
          hint_string_(value.hint_string) {
        info.type = value.type;
        info.name = name_.pointer();
        info.class_name = class_name_.pointer();
        info.hint = value.hint;
        api.string_new_with_utf8_chars(&string_, hint_string_.c_str());
        info.hint_string = &string_;
        info.usage = value.usage;
    }
    PropertyInfo(const PropertyInfo&) = delete;
    PropertyInfo& operator=(const PropertyInfo&) = delete;
    ~PropertyInfo() { api.variant_get_ptr_destructor(GDEXTENSION_VARIANT_TYPE_STRING)(&string_); }

    GDExtensionPropertyInfo info{};

 private:
    StringName name_, class_name_;
    std::string hint_string_;
    void* string_ = nullptr;
};

}  // namespace

ClassEntry::ClassEntry(const char* name, const char* parent, Factory factory, bool is_runtime,
                       bool is_exposed)
    : name_(name), parent_(parent), factory_(factory) {
    GDExtensionClassCreationInfo4 info{};
    info.is_exposed = is_exposed ? 1 : 0;
    info.is_runtime = is_runtime ? 1 : 0;
    info.notification_func = [](void* instance, std::int32_t what, GDExtensionBool) {
        static_cast<Instance*>(instance)->notified(what);
    };
    info.create_instance_func = &ClassEntry::create;
    info.free_instance_func = [](void*, void* instance) {
        delete static_cast<Instance*>(instance);
    };
    info.get_virtual_func = &ClassEntry::find_virtual;
    info.class_userdata = this;
    api.classdb_register_extension_class4(api.library, name_.pointer(), parent_.pointer(), &info);
}

ClassEntry::~ClassEntry() { api.classdb_unregister_extension_class(api.library, name_.pointer()); }

GDExtensionObjectPtr ClassEntry::create(void* entry, GDExtensionBool notify) {
    const auto& self = *static_cast<ClassEntry*>(entry);
    const Object object{api.classdb_construct_object2(self.parent_.pointer())};
    Instance* instance = self.factory_(object);
    api.object_set_instance(object.pointer, self.name_.pointer(), instance);
    static constexpr GDExtensionInstanceBindingCallbacks kCallbacks{};
    api.object_set_instance_binding(object.pointer, api.library, instance, &kCallbacks);
    if (notify != 0) object.finish_construction();
    return object.pointer;
}

GDExtensionClassCallVirtual ClassEntry::find_virtual(void* entry,
                                                     GDExtensionConstStringNamePtr name,
                                                     std::uint32_t /*hash*/) {
    for (const auto& [own, function] : static_cast<ClassEntry*>(entry)->virtuals_)
        if (own->is(name)) return function;
    return nullptr;
}

void ClassEntry::call(void* method, void* instance, const GDExtensionConstVariantPtr* arguments,
                      GDExtensionInt count, GDExtensionVariantPtr result,
                      GDExtensionCallError* error) {
    const auto& bound = *static_cast<BoundMethod*>(method);
    const auto expected = static_cast<GDExtensionInt>(bound.arguments.size());
    if (count != expected) {
        error->error = count < expected ? GDEXTENSION_CALL_ERROR_TOO_FEW_ARGUMENTS
                                        : GDEXTENSION_CALL_ERROR_TOO_MANY_ARGUMENTS;
        error->expected = static_cast<std::int32_t>(expected);
        return;
    }
    std::vector<Value> values;
    for (GDExtensionInt i = 0; i < count; ++i) values.push_back(Value::copy(arguments[i]));
    const Value value = bound.method(*static_cast<Instance*>(instance), values.data());
    api.variant_destroy(result);
    api.variant_new_copy(result, value.data());
    error->error = GDEXTENSION_CALL_OK;
}

void ClassEntry::call_by_pointers(void* method, void* instance,
                                  const GDExtensionConstTypePtr* arguments, void* result) {
    const auto& bound = *static_cast<BoundMethod*>(method);
    std::vector<Value> values;
    for (std::size_t i = 0; i < bound.arguments.size(); ++i)
        values.push_back(Value::of_type(bound.arguments[i].type, arguments[i]));
    const Value value = bound.method(*static_cast<Instance*>(instance), values.data());
    if (bound.result.type == GDEXTENSION_VARIANT_TYPE_NIL) return;
    if (bound.result.hint == kResourceHint) {
        const Object object = value.to_object();
        if (object) api.ref_set_object(result, object.pointer);
        return;
    }
    const GDExtensionPtrDestructor destroy = api.variant_get_ptr_destructor(bound.result.type);
    if (destroy != nullptr) destroy(result);
    api.get_variant_to_type_constructor(bound.result.type)(
        result, const_cast<GDExtensionVariantPtr>(value.data()));
}

void ClassEntry::add_method(const char* name, Method method, ValueInfo result,
                            std::vector<ValueInfo> arguments) {
    methods_.push_back(std::make_unique<BoundMethod>(
        BoundMethod{std::move(method), std::move(result), std::move(arguments)}));
    BoundMethod& bound = *methods_.back();
    std::vector<std::unique_ptr<PropertyInfo>> infos;
    std::vector<GDExtensionPropertyInfo> plain;
    for (const ValueInfo& argument : bound.arguments) {
        infos.push_back(std::make_unique<PropertyInfo>(argument));
        plain.push_back(infos.back()->info);
    }
    std::vector<GDExtensionClassMethodArgumentMetadata> metadata(
        plain.size(), GDEXTENSION_METHOD_ARGUMENT_METADATA_NONE);
    PropertyInfo returned(bound.result);
    StringName method_name(name);
    GDExtensionClassMethodInfo info{};
    info.name = method_name.pointer();
    info.method_userdata = &bound;
    info.call_func = &ClassEntry::call;
    info.ptrcall_func = &ClassEntry::call_by_pointers;
    info.method_flags = GDEXTENSION_METHOD_FLAGS_DEFAULT;
    info.has_return_value = bound.result.type != GDEXTENSION_VARIANT_TYPE_NIL ? 1 : 0;
    info.return_value_info = &returned.info;
    info.return_value_metadata = GDEXTENSION_METHOD_ARGUMENT_METADATA_NONE;
    info.argument_count = static_cast<std::uint32_t>(plain.size());
    info.arguments_info = plain.data();
    info.arguments_metadata = metadata.data();
    api.classdb_register_extension_class_method(api.library, name_.pointer(), &info);
}

void ClassEntry::add_property(ValueInfo info, Method get, Method set) {
    const std::string getter = "get_" + info.name, setter = set ? "set_" + info.name : "";
    ValueInfo argument = info;
    add_method(getter.c_str(), std::move(get), info);
    if (set) add_method(setter.c_str(), std::move(set), {}, {std::move(argument)});
    const PropertyInfo property(info);
    api.classdb_register_extension_class_property(api.library, name_.pointer(), &property.info,
                                                  StringName(setter.c_str()).pointer(),
                                                  StringName(getter.c_str()).pointer());
}

void ClassEntry::add_virtual(const char* name, GDExtensionClassCallVirtual function) {
    virtuals_.emplace_back(std::make_unique<StringName>(name), function);
}

}  // namespace aula::godot
