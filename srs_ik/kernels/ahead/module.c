    {"target", target, METH_NOARGS, "The kind of processor that the kernels at work are compiled for."},
    {NULL, NULL, 0, NULL},
};

static int fill(PyObject *module) {
    if (srs_ik_target() == NULL) {
        PyErr_SetString(PyExc_ImportError, "they are for " KINDS ", which this processor is not");
        return -1;
    }
    PyObject *numpy = PyImport_ImportModule("numpy");
    if (numpy == NULL) return -1;
    PyObject *dtype = PyObject_GetAttrString(numpy, "dtype");
    array_type = (PyTypeObject *)PyObject_GetAttrString(numpy, "ndarray");
    for (int i = 0; dtype != NULL && i < ELEMENTS; i++) dtypes[i] = PyObject_CallFunction(dtype, "s", dtype_names[i]);
    Py_XDECREF(dtype);
    Py_DECREF(numpy);
    if (array_type == NULL || PyErr_Occurred()) return -1;
    return PyModule_AddStringConstant(module, "digests", DIGESTS);
}

static PyModuleDef_Slot slots[] = {{Py_mod_exec, fill}, {0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, .m_name = "entries", .m_size = 0, .m_methods = methods, .m_slots = slots};

PyMODINIT_FUNC PyInit_entries(void) { return PyModuleDef_Init(&definition); }
