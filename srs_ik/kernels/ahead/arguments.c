/* Arguments of a call from Python: arrays of NumPy in C order, and numbers. */
#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdarg.h>
#include "srs_ik.h"

/* An array of NumPy as its stable ABI lays it out; a buffer of the buffer protocol would cost more than a solve. */
typedef struct {
    PyObject_HEAD
    void *data;
    int axes;
    Py_ssize_t *dimensions, *strides;
    PyObject *base, *dtype;
    int flags;
} array_object;

#define READ (0x1 | 0x100)
#define WRITTEN (READ | 0x400)

enum { float_, int_, byte_, bool_, ELEMENTS };
static PyObject *target(PyObject *self, PyObject *nothing) {
    (void)self, (void)nothing;
    return PyUnicode_FromString(srs_ik_target());
}

static const char *const dtype_names[ELEMENTS] = {"float64", "int64", "int8", "bool"};
static PyObject *dtypes[ELEMENTS];
static PyTypeObject *array_type;

/* The figures of an array of a kind, or NULL without an exception. */
static inline void *array(PyObject *given, int element, int axes, int flags, const Py_ssize_t **dimensions) {
    if (Py_TYPE(given) != array_type && !PyType_IsSubtype(Py_TYPE(given), array_type)) return NULL;
    const array_object *a = (const array_object *)given;
    if (a->axes != axes || (a->flags & flags) != flags) return NULL;
    if (a->dtype != dtypes[element]) {
        const int same = PyObject_RichCompareBool(a->dtype, dtypes[element], Py_EQ);
        if (same < 0) PyErr_Clear();
        if (same != 1) return NULL;
    }
    *dimensions = a->dimensions;
    return a->data;
}

/* Whether a size is what it was before in the same call; unknown sizes are -1. */
#define fits(size, dimension) ((size) < 0 ? ((size) = (dimension), true) : (size) == (dimension))

static inline bool read_float(PyObject *given, double *value) {
    *value = PyFloat_AsDouble(given);
    return *value != -1.0 || !PyErr_Occurred();
}

static inline bool read_int(PyObject *given, int64_t *value) {
    if (PyLong_CheckExact(given)) {
        *value = PyLong_AsLongLong(given);
    } else {
        PyObject *index = PyNumber_Index(given);
        if (index == NULL) return false;
        *value = PyLong_AsLongLong(index);
        Py_DECREF(index);
    }
    return *value != -1 || !PyErr_Occurred();
}

static inline bool read_bool(PyObject *given, bool *value) {
    const int truth = given == Py_True ? 1 : given == Py_False ? 0 : PyObject_IsTrue(given);
    *value = truth == 1;
    return truth >= 0;
}

static PyObject *wrong_count(const char *entry, int wanted, Py_ssize_t count) {
    return PyErr_Format(PyExc_TypeError, "%s takes %d arguments, not %zd", entry, wanted, count);
}

static PyObject *wrong_number(const char *entry, const char *name) {
    if (!PyErr_Occurred()) PyErr_Format(PyExc_TypeError, "%s: %s is no number", entry, name);
    return NULL;
}

static PyObject *wrong_array(const char *entry, const char *name, const char *kind, PyObject *given) {
    PyObject *shape = PyObject_GetAttrString(given, "shape");
    if (shape == NULL) PyErr_Clear();
    PyErr_Format(PyExc_TypeError, "%s: %s must be %s in C order, not %R of shape %S", entry, name, kind,
                 (PyObject *)Py_TYPE(given), shape ? shape : Py_None);
    Py_XDECREF(shape);
    return NULL;
}

static PyObject *tuple_of(int count, ...) {
    va_list values;
    va_start(values, count);
    PyObject *tuple = PyTuple_New(count);
    for (int i = 0; i < count; i++) {
        PyObject *value = va_arg(values, PyObject *);
        if (value == NULL) Py_CLEAR(tuple);
        if (tuple == NULL) Py_XDECREF(value);
        else PyTuple_SetItem(tuple, i, value);
    }
    va_end(values);
    return tuple;
}

#define ENTRY(name) {#name, (PyCFunction)(void (*)(void))name, METH_FASTCALL, NULL}
