#include <pybind11/pybind11.h>

#include "apps/python/scene_bindings.h"
#include "aula/exception.h"

/// The extension module of the package aula, which checks and converts the arguments.
PYBIND11_MODULE(_aula, module) {
    pybind11::register_exception<aula::InputError>(module, "Error", PyExc_ValueError)
        .attr("__module__") = "aula";
    pybind11::register_exception<aula::Failure>(module, "Failure", PyExc_RuntimeError)
        .attr("__module__") = "aula";
    module.attr("version") = AULA_VERSION;
    aula::bind_scenes(module);
    aula::bind_results(module);
}
