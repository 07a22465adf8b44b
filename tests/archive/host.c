/* host PLUGIN LIBRARY SCENE: loads the LV2 plugins, and makes a scene audible by the C interface. */
#define _POSIX_C_SOURCE 200809L
#include <aula.h>
#include <dlfcn.h>
#include <lv2/core/lv2.h>
#include <stdio.h>
#include <stdlib.h>

static void* function(const char* file, const char* name) {
    void* library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
    void* found = library != NULL ? dlsym(library, name) : NULL;
    if (found == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        exit(1);
    }
    return found;
}

int main(int count, char** arguments) {
    if (count != 4) return 2;
    LV2_Descriptor_Function descriptor;
    *(void**)&descriptor = function(arguments[1], "lv2_descriptor");
    uint32_t plugins = 0;
    while (descriptor(plugins) != NULL) printf("%s\n", descriptor(plugins++)->URI);

    int (*load)(const char*, aula_scene**);
    int (*create)(const aula_scene*, const aula_options*, aula_room**);
    void (*destroy)(aula_room*);
    *(void**)&load = function(arguments[2], "aula_scene_load");
    *(void**)&create = function(arguments[2], "aula_room_create");
    *(void**)&destroy = function(arguments[2], "aula_room_destroy");
    aula_scene* scene = NULL;
    aula_room* room = NULL;
    if (plugins == 0 || load(arguments[3], &scene) != AULA_OK ||
        create(scene, NULL, &room) != AULA_OK)
        return 1;
    destroy(room);
    return 0;
}
