# The program `greenstick` for a render farm: docker build -t greenstick . && docker run --rm -v "$PWD:/work" greenstick break pole.ply
FROM rust:1-slim-bookworm AS build
WORKDIR /source
COPY . .
RUN cargo install --locked --path apps/cli --root /built

FROM debian:bookworm-slim
COPY --from=build /built/bin/greenstick /usr/local/bin/greenstick
COPY LICENSE-MIT LICENSE-APACHE /usr/share/doc/greenstick/
# Files are written as the caller: give the numbers of user and group by `--user "$(id -u):$(id -g)"`.
WORKDIR /work
ENTRYPOINT ["greenstick"]
CMD ["--help"]
