# One image for every process; PROCESS says which one a container runs. How small, and why: docs/decisions/0029-containers.md
# For the very same base each time, name it by its digest: docker-compose build --build-arg BASE=python:3.11-slim@sha256:...
ARG BASE=python:3.11-slim
FROM ${BASE} AS packages

ENV PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore PIP_DISABLE_PIP_VERSION_CHECK=1
# Constraints count for what packages are built with, too.
ENV PIP_CONSTRAINT=/build/constraints.txt PIP_BUILD_CONSTRAINT=/build/constraints.txt
# What is installed: run.txt, or camera.txt for the camera's process as well.
ARG LOCK=run.txt
WORKDIR /build
# What the project needs changes less often than the project: a layer of its own.
COPY pyproject.toml constraints.txt locks/${LOCK} ./
# Left out: what only the libraries' own tests and compilers need.
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
# Compiled here, since nothing can be written later; by content, not by date, so that the same source gives the same bytes.
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
# Safe and fresh, as common/health.py has it. Unhealthy within 15 s; what was never healthy is starting for its first 15 s.
HEALTHCHECK --interval=5s --timeout=4s --start-period=15s --retries=2 \
    CMD ["sh", "-c", "exec python -m common.health /session/$PROCESS.json"]
CMD ["sh", "-c", "exec python -m teletaction $PROCESS --config /config/$PROCESS.toml"]
