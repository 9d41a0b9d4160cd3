# The command with path tracing: docker build -t scenelang . && docker run --rm -v "$PWD:/scenes" scenelang check a.scene
FROM python:3.11-slim

COPY . /source
WORKDIR /source
RUN python -m pip install --no-cache-dir --disable-pip-version-check -c constraints.txt ".[final]"
RUN scenelang render examples/chessboard.scene -o /tmp/chessboard.png --quality draft --size 64x48 && rm /tmp/chessboard.png

# A number, so that no user needs to be made; files in /scenes belong to it, or to whom `docker run --user` names.
USER 1000:1000
ENV HOME=/tmp
WORKDIR /scenes
ENTRYPOINT ["scenelang"]
CMD ["--help"]
