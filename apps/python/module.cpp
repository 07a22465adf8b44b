#include <pybind11/pybind11.h>

#include <exception>
#include <string>
#include <utility>

#include "apps/output/printable.h"
#include "apps/python/scene_bindings.h"
#include "aula/exception.h"

/// The extension module of the package aula, which checks and converts the arguments.
PYBIND11_MODULE(_aula, module) {
    // Arrays of NumPy 2 have another layout, which pybind11 knows from 2.12 on.
    if (PYBIND11_VERSION_HEX < 0x020C0000) {
        const auto version = pybind11::module_::import("numpy").attr("__version__");
        if (std::stoi(pybind11::cast<std::string>(version)) >= 2)
            throw pybind11::import_error(
                "aula was built with pybind11 " AULA_PYBIND11_VERSION
                ", which does not support NumPy 2; expected NumPy 1, or pybind11 2.12 or later");
    }
    static pybind11::exception<aula::InputError> error(module, "Error", PyExc_ValueError);
    static pybind11::exception<aula::Failure> failure(module, "Failure", PyExc_RuntimeError);
    error.attr("__module__") = "aula";
    failure.attr("__module__") = "aula";
    pybind11::register_exception_translator([](std::exception_ptr thrown) {
        try {
            std::rethrow_exception(std::move(thrown));
        } catch (const aula::InputError& e) {
            PyErr_SetString(error.ptr(), aula::printable_line(e.what()).c_str());
        } catch (const aula::Failure& e) {
            PyErr_SetString(failure.ptr(), aula::printable_line(e.what()).c_str());
        }
    });
    module.attr("version") = AULA_VERSION;
    aula::bind_scenes(module);
    aula::bind_results(module);
    aula::bind_analysis(module);
    aula::bind_auralizer(module);
}
