const char *srs_ik_target(void) { return at < 0 ? NULL : targets[at].name; }

int srs_ik_choose(const char *target) {
    for (int i = 0; i < TARGETS; i++)
        if (strcmp(targets[i].name, target) == 0 && fits(i)) {
            at = i;
            return 0;
        }
    return 1;
}

/* The best that this machine takes; SRS_IK_TARGET names another. */
__attribute__((constructor)) static void choose_best(void) {
    for (int i = 0; i < TARGETS; i++)
        if (fits(i)) at = i;
    const char *wanted = getenv("SRS_IK_TARGET");
    if (wanted != NULL) srs_ik_choose(wanted);
}

int srs_ik_read_limb(const char *path, double family[4][SRS_IK_LIMB_SIZE]) {
    char head[16];
    int64_t count;
    FILE *file = fopen(path, "rb");
    if (file == NULL) return 2;
    const size_t figures = 4 * SRS_IK_LIMB_SIZE;
    const bool whole = fread(head, sizeof head, 1, file) == 1 && fread(&count, sizeof count, 1, file) == 1;
    const bool fitting = whole && memcmp(head, limb_mark, sizeof head) == 0 && count == (int64_t)figures;
    const bool read = fitting && fread(family, sizeof(double), figures, file) == figures && fgetc(file) == EOF;
    fclose(file);
    return read ? 0 : 1;
}
