/* SPDX-License-Identifier: Apache-2.0 */
/* The extension module cellwalk._cellwalk, in Python's limited interface of 3.11: one file serves all later versions, and
 * arrays come and go by the buffer protocol, without NumPy's headers. */
#include "extension.h"
#include "reach.h"
#include "sun.h"

#include <stddef.h>

static PyObject *list_kernels(PyObject *self, PyObject *unused) {
    (void)self;
    (void)unused;
    PyObject *list = PyList_New(0);
    for (size_t k = 0; k < cw_kernel_count() && list != NULL; k++) {
        const cw_kernel_info info = cw_kernel_describe(cw_kernel_at(k));
        PyObject *row = Py_BuildValue("(sssIN)", info.name, info.what, cw_isa_name(info.isa), info.width,
                                      PyBool_FromLong(info.available));
        if (row == NULL || PyList_Append(list, row) != 0) Py_CLEAR(list);
        Py_XDECREF(row);
    }
    return list;
}

/* The clock of `--time`: None if the text is none. */
static PyObject *parse_time(PyObject *self, PyObject *arguments) {
    const char *text;
    double seconds;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "s:parse_time", &text)) return NULL;
    if (!cw_sun_parse_time(text, &seconds)) Py_RETURN_NONE;
    return PyFloat_FromDouble(seconds);
}

static PyMethodDef functions[] = {
    {"kernels", list_kernels, METH_NOARGS, NULL},
    {"parse_time", parse_time, METH_VARARGS, NULL},
    {"describe_crs", describe_crs, METH_VARARGS, NULL},
    {"make_pool", make_pool, METH_VARARGS, NULL},
    {"read_raster", read_raster, METH_VARARGS, NULL},
    {"find_scale", find_scale, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

/* cellwalk/_hits.py has them as a NumPy dtype. */
_Static_assert(sizeof(cw_hit) == 24 && offsetof(cw_hit, i) == 4 && offsetof(cw_hit, triangle) == 12 &&
                   offsetof(cw_hit, v) == 20,
               "t, i, j, triangle, u, v without gaps");

static int add_type(PyObject *module, PyType_Spec *spec, const char *name) {
    PyObject *type = PyType_FromModuleAndSpec(module, spec, NULL);
    const int status = type == NULL ? -1 : PyModule_AddObjectRef(module, name, type);
    Py_XDECREF(type);
    return status;
}

/* The pools and GDAL's module belong to the process, and the main interpreter's GIL guards them. */
static int fill(PyObject *module) {
    if (PyInterpreterState_GetID(PyInterpreterState_Get()) != 0) {
        PyErr_SetString(PyExc_ImportError, "cellwalk does not run in sub-interpreters: use threads or processes");
        return -1;
    }
    if (add_type(module, &py_field_spec, "Field") != 0 || add_type(module, &py_geotiff_spec, "GeoTiff") != 0 ||
        PyModule_AddIntConstant(module, "BLOCK", REACH_BLOCK) != 0)
        return -1;
    return PyModule_AddStringConstant(module, "version", cw_version());
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, (void *)fill}, {0, NULL}};

static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, .m_name = "cellwalk._cellwalk", .m_methods = functions,
                                        .m_slots = slots};

PyMODINIT_FUNC PyInit__cellwalk(void);
PyMODINIT_FUNC PyInit__cellwalk(void) { return PyModuleDef_Init(&definition); }
