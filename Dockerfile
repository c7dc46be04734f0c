# One image for every process; PROCESS says which one a container runs.
FROM python:3.11-slim

ENV PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore PYTHONUNBUFFERED=1 PYTHONDONTWRITEBYTECODE=1 MPLCONFIGDIR=/tmp

RUN useradd --uid 10001 --create-home --shell /usr/sbin/nologin teletaction \
    && install -d -o teletaction -g teletaction -m 0700 /keys/remote /keys/operator /keys/console \
    && install -d -o teletaction -g teletaction /session

WORKDIR /build
# What the project needs changes less often than the project: a layer of its own.
COPY pyproject.toml constraints.txt ./
RUN python -c "import tomllib; project = tomllib.load(open('pyproject.toml', 'rb'))['project']; \
        print(*project['dependencies'], *project['optional-dependencies']['console'], sep='\n')" > requirements.txt \
    && pip install --only-binary=:all: -c constraints.txt -r requirements.txt

COPY LICENSE README.md ./
COPY common common
COPY remote_site remote_site
COPY operator_site operator_site
COPY sim_sensors sim_sensors
COPY teletaction teletaction
RUN pip install --no-deps . && cp -r remote_site/tables /calibration && rm -rf /build/*
COPY docker/*.sh /usr/local/bin/

WORKDIR /session
USER teletaction
ENV PROCESS=remote
HEALTHCHECK --interval=5s --timeout=5s --start-period=15s --retries=3 \
    CMD python -m common.health "/session/$PROCESS.json"
CMD ["run_process.sh"]
