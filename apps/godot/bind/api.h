#pragma once

#include <gdextension_interface.h>

#include <string>

namespace aula::godot {

// NAME of the engine and the middle of its type's name.
#define AULA_GODOT_FUNCTIONS(F)                                                         \
    F(print_error_with_message, PrintErrorWithMessage)                                  \
    F(variant_new_copy, VariantNewCopy)                                                 \
    F(variant_new_nil, VariantNewNil)                                                   \
    F(variant_destroy, VariantDestroy)                                                  \
    F(variant_call, VariantCall)                                                        \
    F(variant_construct, VariantConstruct)                                              \
    F(variant_get_indexed, VariantGetIndexed)                                           \
    F(variant_get_type, VariantGetType)                                                 \
    F(variant_stringify, VariantStringify)                                              \
    F(variant_get_ptr_destructor, VariantGetPtrDestructor)                              \
    F(get_variant_from_type_constructor, GetVariantFromTypeConstructor)                 \
    F(get_variant_to_type_constructor, GetVariantToTypeConstructor)                     \
    F(variant_get_ptr_internal_getter, GetVariantGetInternalPtrFunc)                    \
    F(string_new_with_utf8_chars, StringNewWithUtf8Chars)                               \
    F(string_to_utf8_chars, StringToUtf8Chars)                                          \
    F(string_name_new_with_utf8_chars, StringNameNewWithUtf8Chars)                      \
    F(packed_float32_array_operator_index_const, PackedFloat32ArrayOperatorIndexConst)  \
    F(packed_int32_array_operator_index_const, PackedInt32ArrayOperatorIndexConst)      \
    F(packed_vector3_array_operator_index_const, PackedVector3ArrayOperatorIndexConst)  \
    F(global_get_singleton, GlobalGetSingleton)                                         \
    F(object_set_instance, ObjectSetInstance)                                           \
    F(object_set_instance_binding, ObjectSetInstanceBinding)                            \
    F(object_get_instance_binding, ObjectGetInstanceBinding)                            \
    F(object_get_instance_from_id, ObjectGetInstanceFromId)                             \
    F(object_get_instance_id, ObjectGetInstanceId)                                      \
    F(object_method_bind_ptrcall, ObjectMethodBindPtrcall)                              \
    F(classdb_get_method_bind, ClassdbGetMethodBind)                                    \
    F(ref_set_object, RefSetObject)                                                     \
    F(classdb_construct_object2, ClassdbConstructObject2)                               \
    F(classdb_register_extension_class4, ClassdbRegisterExtensionClass4)                \
    F(classdb_register_extension_class_method, ClassdbRegisterExtensionClassMethod)     \
    F(classdb_register_extension_class_property, ClassdbRegisterExtensionClassProperty) \
    F(classdb_unregister_extension_class, ClassdbUnregisterExtensionClass)

/// The functions of the engine that the extension calls.
struct Api {
    GDExtensionClassLibraryPtr library = nullptr;
#define AULA_GODOT_MEMBER(name, type) GDExtensionInterface##type name = nullptr;
    AULA_GODOT_FUNCTIONS(AULA_GODOT_MEMBER)
#undef AULA_GODOT_MEMBER
};

/// Filled by load_api() before anything else is called, constant from then on.
extern Api api;

/// Finds the functions; false if the engine, older than 4.4, lacks one.
bool load_api(GDExtensionInterfaceGetProcAddress find, GDExtensionClassLibraryPtr library);

/// Writes an error to Godot's log. [main thread]
void log_error(const std::string& message);

}  // namespace aula::godot
