# One image for every process; PROCESS names the one that a container runs (docs/decisions/0029-containers.md).
# For an identical base each time, give its digest: docker-compose build --build-arg BASE=python:3.11-slim@sha256:...
ARG BASE=python:3.11-slim
FROM ${BASE} AS packages

ENV PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore PIP_DISABLE_PIP_VERSION_CHECK=1
# The constraints apply to build dependencies as well.
ENV PIP_CONSTRAINT=/build/constraints.txt PIP_BUILD_CONSTRAINT=/build/constraints.txt
# Packages to install: run.txt, or camera.txt for the camera's process as well.
ARG LOCK=run.txt
WORKDIR /build
# The dependencies have a layer of their own, because they change less often than the project.
COPY pyproject.toml constraints.txt locks/${LOCK} ./
# Files that only the libraries' own tests and compilers need are removed.
RUN python -m venv --without-pip /opt/teletaction \
    && pip --python /opt/teletaction install --no-compile --only-binary=:all: --no-deps --require-hashes -r ${LOCK} \
    && find /opt/teletaction -depth -type d \( -name tests -o -name sample_data \) -exec rm -r {} + \
    && find /opt/teletaction \( -name '*.pyi' -o -name '*.pxd' -o -name '*.h' -o -name '*.a' \) -delete
COPY LICENSE README.md ./
COPY common common
COPY remote_site remote_site
COPY operator_site operator_site
COPY sim_sensors sim_sensors
COPY teletaction teletaction
# Compiled here, because the container's file system is read-only. Hashes in place of dates make the build reproducible.
RUN pip --python /opt/teletaction install --no-compile --no-deps . \
    && /opt/teletaction/bin/python -m compileall -q --invalidation-mode unchecked-hash /opt/teletaction/lib

FROM ${BASE}
ENV PATH=/opt/teletaction/bin:$PATH PYTHONUNBUFFERED=1 PYTHONDONTWRITEBYTECODE=1 MPLCONFIGDIR=/tmp
RUN useradd --uid 10001 --create-home --shell /usr/sbin/nologin teletaction \
    && install -d -o teletaction -g teletaction -m 0700 /keys/remote /keys/operator /keys/console \
    && install -d -o teletaction -g teletaction /session
COPY remote_site/tables /calibration
COPY docker/*.sh /usr/local/bin/
COPY --from=packages /opt/teletaction /opt/teletaction

WORKDIR /session
USER teletaction
ENV PROCESS=remote
# common/health.py judges the status file. A failure shows within 15 s; a new container may take 15 s to become healthy.
HEALTHCHECK --interval=5s --timeout=4s --start-period=15s --retries=2 \
    CMD ["sh", "-c", "exec python -m common.health /session/$PROCESS.json"]
CMD ["sh", "-c", "exec python -m teletaction $PROCESS --config /config/$PROCESS.toml"]
